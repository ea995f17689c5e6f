"""Run a case file, and print its results."""

from __future__ import annotations

import signal
from pathlib import Path

import typer

from supple import cases
from supple.cases.existing_results import stored_so_far
from supple.error import SelfCorrectionError, correction_numbers
from supple.results.explicit_numbers import explicit_cost_line
from supple.results.run_start import start_lines
from supple.results.run_tables import (
    correction_table,
    cost_line,
    error_lines,
    error_table,
    motion_tables,
)
from supple.simulation.interruption import INTERRUPTIONS, Terminated, raising_terminated
from supple.terminal import ProgressBars, error_console, print_table, progress_bars, say, words


def run_case(
    path: Path,
    folder: Path,
    *,
    resume: bool = False,
    force: bool = False,
    strict: bool = False,
    errors: bool = True,
    allow_code: bool = False,
) -> None:
    """Run the case file at `path` and print its tables; parameters and exceptions as for `cases.run_case`.

    If interrupted by Ctrl-C (SIGINT) or the system (SIGTERM), print what is stored, and exit with 130 or 143.
    """
    with raising_terminated():
        try:
            _run(
                path,
                folder,
                resume=resume,
                force=force,
                strict=strict,
                errors=errors,
                allow_code=allow_code,
            )
        except INTERRUPTIONS as error:
            kept = "; ".join(getattr(error, "__notes__", [])) or stored_so_far(path, folder)
            error_console.print(words("stopped: ", "bold red") + words(kept), soft_wrap=True)
            number = signal.SIGTERM if isinstance(error, Terminated) else signal.SIGINT
            raise typer.Exit(128 + number) from error


def _run(
    path: Path,
    folder: Path,
    *,
    resume: bool,
    force: bool,
    strict: bool,
    errors: bool,
    allow_code: bool,
) -> None:
    bars = progress_bars()
    steps = ProgressBars(bars)
    case = cases.read_case(path, steps.show)
    say(case.title, "bold")
    with bars:
        try:
            result = cases.run_case(
                case,
                folder,
                resume=resume,
                force=force,
                strict=strict,
                errors=errors,
                allow_code=allow_code,
                progress=steps.share,
            )
        except SelfCorrectionError as error:
            if error.rounds:
                print_table(*correction_table(correction_numbers(error.rounds), case.units))
            raise
        steps.finish()
    numbers = result.numbers
    if result.rounds:
        print_table(*correction_table(result.rounds, case.units))
    for table in motion_tables(numbers):
        print_table(*table)
    for name, body in numbers["bodies"].items():
        if "eigenvalues" in body:
            say(f"{name}: {body['eigenvalues']}")
    if numbers["errors"]:
        print_table(*error_table(numbers))
        for line in error_lines(numbers):
            say(line)
    for line in start_lines(numbers):
        say(line)
    say(explicit_cost_line(numbers) if "steps" in numbers else cost_line(result.solution.statistics))
    say(f"Results are in {folder}/")
