"""Interruption of runs, by Ctrl-C (SIGINT) or by the system (SIGTERM), and the state of the result file."""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from supple.storage import ResultFile

LOGGER = logging.getLogger("supple")


class Terminated(SystemExit):
    """The process received SIGTERM; if uncaught, the process ends with the exit code of this signal."""

    def __init__(self) -> None:
        super().__init__(128 + signal.SIGTERM)


INTERRUPTIONS = (KeyboardInterrupt, Terminated)
"""Exceptions by which the user or the system interrupts a run."""
_A_MOMENT = 0.05
"""Delay before an interruption is sent again, s."""


@contextmanager
def raising_terminated() -> Iterator[bool]:
    """Within the block SIGTERM raises Terminated, unless the program has set another handler.

    Yields whether SIGTERM raises: False if there is a handler, or outside the main thread.
    """
    handles = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    )
    if not handles:
        yield False
        return
    signal.signal(signal.SIGTERM, _raise_terminated)
    try:
        with _not_swallowed():
            yield True
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


@contextmanager
def _not_swallowed() -> Iterator[None]:
    """Within the block an interruption that Python could not raise is sent again shortly after.

    A signal may arrive in a finaliser, where Python prints the exception and continues.
    """
    before, again = sys.unraisablehook, []

    def hook(unraisable: sys.UnraisableHookArgs) -> None:
        if not isinstance(unraisable.exc_value, INTERRUPTIONS):
            before(unraisable)
            return
        number = signal.SIGTERM if isinstance(unraisable.exc_value, Terminated) else signal.SIGINT
        again.append(threading.Timer(_A_MOMENT, os.kill, (os.getpid(), number)))
        again[-1].start()

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before
        for timer in again:
            timer.cancel()


@contextmanager
def noted_interruption(file: ResultFile) -> Iterator[None]:
    """Add a note with the last time stored in the file to an interruption within the block."""
    with raising_terminated() as is_ours:
        try:
            yield
        except INTERRUPTIONS as error:
            note = _kept(file)
            error.add_note(note)
            if is_ours and isinstance(error, Terminated):
                # An exit is not printed; a traceback prints the note of a Ctrl-C.
                LOGGER.warning(note)
            raise


def _kept(file: ResultFile) -> str:
    if file.last_time == -float("inf"):
        return f"the run was stopped before its first output time; {file.path} has no output"
    return (
        f"the run up to t = {file.last_time:g} is stored in {file.path}; the same call continues it "
        "(supple run: with --resume)"
    )


def _raise_terminated(_number: int, _frame: FrameType | None) -> None:
    raise Terminated
