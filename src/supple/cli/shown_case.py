"""A case that a command computes: its title, its progress bars, and its end by the user or the system."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import typer

from supple.cases import Case, read_case
from supple.integrate import StepProgress
from supple.simulation.interruption import INTERRUPTIONS, Terminated, raising_terminated
from supple.terminal import ProgressBars, error_console, progress_bars, say, words


@contextmanager
def shown_case(path: Path) -> Iterator[tuple[Case, StepProgress]]:
    """Print the title of the case at `path`, and within the block a bar for each step that is reported."""
    bars = progress_bars()
    steps = ProgressBars(bars)
    case = read_case(path, steps.show)
    say(case.title, "bold")
    with bars:
        yield case, steps.share
        steps.finish()


@contextmanager
def stated_interruption(kept: Callable[[BaseException], str]) -> Iterator[None]:
    """If interrupted by Ctrl-C (SIGINT) or the system (SIGTERM), print what is kept; exit with 130 or 143."""
    with raising_terminated():
        try:
            yield
        except INTERRUPTIONS as error:
            error_console.print(words("stopped: ", "bold red") + words(kept(error)), soft_wrap=True)
            number = signal.SIGTERM if isinstance(error, Terminated) else signal.SIGINT
            raise typer.Exit(128 + number) from error
