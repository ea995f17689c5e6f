"""Output of the commands: bars, lines, tables and warnings on standard output, errors on standard error.

Lines and tables are INFO records of the logger "supple.cli". `shown_log` prints them on the console; a
program that calls a command may redirect them. Library code logs to "supple" and prints nothing.
"""

from __future__ import annotations

import io
import logging
import os
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TextIO

import typer
from rich.console import Console, RenderableType
from rich.progress import (
    BarColumn,
    Progress,
    SpinnerColumn,
    TaskID,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
)
from rich.table import Column, Table
from rich.text import Text

from supple.errors import SuppleError, SuppleWarning

MISTAKE = 2
"""Exit code for an error raised by supple or the operating system, or for a lack of memory."""

FAULT = 1
"""Exit code for any other error, which is a fault of supple."""

WIDTH_OF_FILES = 140
"""Width, in characters, of output that is not on a terminal; the widest table of the commands fits."""


def _console(*, stderr: bool = False) -> Console:
    made = Console(stderr=stderr)
    if not made.is_terminal and "COLUMNS" not in os.environ:
        made.width = WIDTH_OF_FILES
    return made


console = _console()
error_console = _console(stderr=True)
LOGGER = logging.getLogger("supple.cli")


class PrintedMessage:
    """Content of a log record to be printed; a log file contains it as plain text."""

    def __init__(self, content: RenderableType, *, soft_wrap: bool = False) -> None:
        self._content, self._soft_wrap = content, soft_wrap

    def __str__(self) -> str:
        text = io.StringIO()
        self.print_on(Console(file=text, width=WIDTH_OF_FILES))
        return text.getvalue().rstrip("\n")

    def print_on(self, console: Console) -> None:
        """Print the content on a console, in colours if the console shows them."""
        console.print(self._content, soft_wrap=self._soft_wrap)


class ConsoleHandler(logging.Handler):
    """Prints the output of commands, and records of the library from level WARNING."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record is shown."""
        return record.name == LOGGER.name or record.levelno >= logging.WARNING

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record."""
        if isinstance(record.msg, PrintedMessage):
            record.msg.print_on(console)
        else:
            console.print(words(record.getMessage()), soft_wrap=True)


@contextmanager
def shown_log() -> Iterator[None]:
    """Print log records on the console."""
    logger, handler = logging.getLogger("supple"), ConsoleHandler()
    level = LOGGER.level
    logger.addHandler(handler)
    LOGGER.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOGGER.setLevel(level)
        logger.removeHandler(handler)


def progress_bars(on: Console | None = None, *, transient: bool = False) -> Progress:
    """Bars with the elapsed time, by default on standard output; a step of unknown length has a spinner.

    transient : the bars disappear at the end
    """
    return Progress(
        SpinnerColumn(finished_text="[green]*[/green]"),
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=30),
        TaskProgressColumn(show_speed=False),
        TimeElapsedColumn(),
        console=on or console,
        transient=transient,
    )


def plain(text: str) -> str:
    """The text with control characters and undecodable bytes escaped.

    The result may contain brackets: print it by `words`.
    """
    return "".join(
        sign if sign.isprintable() or sign == "\n" else sign.encode("unicode_escape").decode("ascii")
        for sign in text
    )


def words(text: str, style: str = "") -> Text:
    """A text to print literally: brackets in names are not markup."""
    return Text(plain(text), style=style)


def say(text: str, style: str = "") -> None:
    """Log a line to be printed literally."""
    LOGGER.info(PrintedMessage(words(text, style), soft_wrap=True))


def show_any_character() -> None:
    """Make standard output and error escape characters that their encoding lacks, instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def worded(step: str, detail: str = "") -> str:
    """A step and its detail in one line, with control characters escaped."""
    return plain(f"{step}: {detail}" if detail else step)


@contextmanager
def shown_step(step: str) -> Iterator[Callable[..., None]]:
    """Show a step with a spinner until the block ends; yield a function (step, detail) that shows a new step.

    The text is printed literally: brackets in names of bodies are not markup.
    """
    with console.status(words(step)) as status:

        def show(step: str, detail: str = "", /) -> None:
            status.update(words(worded(step, detail)))

        yield show


class ProgressBars:
    """One bar per step, in order; a step of unknown length has a spinner until the next step begins."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._tasks: dict[str, TaskID] = {}
        self._spinning: TaskID | None = None

    def show(self, step: str, detail: str = "", /) -> None:
        """A step of unknown length begins, or makes progress."""
        self._spinning = self._task(step, None)
        self._bars.update(self._spinning, description=worded(step, detail))

    def share(self, step: str, fraction: float) -> None:
        """A step begins, or makes progress."""
        self._bars.update(self._task(step, 1.0), completed=fraction)

    def finish(self) -> None:
        """Finish the step with a spinner."""
        if self._spinning is not None:
            self._bars.update(self._spinning, total=1.0, completed=1.0)

    def _task(self, step: str, total: float | None) -> TaskID:
        if step not in self._tasks:
            self.finish()
            self._spinning, self._tasks[step] = None, self._bars.add_task(step, total=total)
        return self._tasks[step]


def bar(bars: Progress, label: str) -> Callable[[float], None]:
    """Add a bar; the returned function sets its finished fraction, 0 to 1."""
    task = bars.add_task(label, total=1.0)
    return lambda fraction: bars.update(task, completed=fraction)


def print_table(title: str, heads: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """Log a table of text to be printed."""
    shown = Table(*(Column(words(head)) for head in heads), title=words(title))
    for row in rows:
        shown.add_row(*map(words, row))
    LOGGER.info(PrintedMessage(shown))


def print_rows(title: str, rows: Iterable[tuple[str, str]]) -> None:
    """Log names with descriptions, to be printed."""
    shown = Table(title=words(title), show_header=False)
    for row in rows:
        shown.add_row(*map(words, row))
    LOGGER.info(PrintedMessage(shown))


@contextmanager
def reported_errors(*, debug: bool) -> Iterator[None]:
    """Print log records; print an error as a message and exit. With `debug` the error is raised.

    An error raised by supple or the operating system, or a lack of memory, gives the exit code `MISTAKE`. Any
    other error is a fault of supple (exit code `FAULT`), and the message states this.
    """
    try:
        with shown_log():
            yield
    except (typer.Exit, typer.Abort):
        raise
    except Exception as error:
        if debug:
            raise
        message, code = _message_of(error)
        error_console.print(words("error: ", "bold red") + words(message), soft_wrap=True)
        raise typer.Exit(code) from error


def _message_of(error: Exception) -> tuple[str, int]:
    """Message and exit code of an error."""
    match error:
        case SuppleError():
            return str(error), MISTAKE
        case MemoryError():
            return f"not enough memory ({error or 'none is left'}): use a smaller model", MISTAKE
        case OSError() if error.filename is not None:
            return (
                f"{os.fsdecode(error.filename)}: {error.strerror}; check the path and its permissions",
                MISTAKE,
            )
        case OSError():
            return f"{error}; check the paths given, and the disk", MISTAKE
        case _:
            return (
                f"{type(error).__name__}: {error}\nThis is a fault of supple, not of its input. "
                "Run the command again with --debug and report the traceback with the input",
                FAULT,
            )


@contextmanager
def reported_warnings() -> Iterator[None]:
    """Print every warning of supple when it is issued, even if repeated, without a source line."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", SuppleWarning)
        show_others = warnings.showwarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, SuppleWarning):
                console.print(words("warning: ", "bold yellow") + words(str(message)), soft_wrap=True)
            else:
                show_others(message, category, filename, lineno, file, line)

        warnings.showwarning = show  # ty: ignore[invalid-assignment]
        yield
