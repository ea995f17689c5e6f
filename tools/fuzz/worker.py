"""A process that reads mutated files, within limits of memory and time, and the outcome of each file."""

from __future__ import annotations

import multiprocessing as mp
import os
import resource
import signal
import traceback
import warnings
from collections.abc import Callable
from enum import StrEnum
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

from forked_copy import fork_copies

from supple.errors import SuppleError

SECONDS = 20.0
"""On a processor, after which a file hangs its reader."""
WAITING = 4
"""Times as long by the clock: the computer may be busy, and a reader may sleep."""
MEMORY = 2 * 2**30
"""Address space beyond that of a process that has read nothing."""


class Outcome(StrEnum):
    """What became of a file."""

    GOOD = "good"
    REFUSED = "refused"
    TRACEBACK = "traceback"
    MEMORY = "memory"
    SIGNAL = "signal"
    HANG = "hang"

    @property
    def is_fault(self) -> bool:
        """Whether the reader failed; a file that is read, or refused in words, is in order."""
        return self not in (Outcome.GOOD, Outcome.REFUSED)


class Finding(NamedTuple):
    """An outcome with its message and the line of the sources where it arose."""

    outcome: Outcome
    message: str = ""
    where: str = ""


class Worker:
    """One forked process at a time, begun anew where a file ends it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process: mp.Process | None = None
        self._pipe: Connection | None = None

    def read(self, reader: Callable[[Path], object], name: str, content: bytes) -> Finding:
        """What becomes of a file of that name and content; `reader` is known to the process by fork."""
        path = self._folder / name
        path.write_bytes(content)
        if self._process is None or not self._process.is_alive() or self._reader is not reader:
            self._begin(reader)
        assert self._pipe is not None
        assert self._process is not None
        try:
            self._pipe.send(path)
            if not self._pipe.poll(WAITING * SECONDS):
                self.end()
                return Finding(Outcome.HANG, f"no answer within {WAITING * SECONDS:g} s by the clock")
            finding, seconds = self._pipe.recv()
            if seconds > SECONDS:
                return Finding(Outcome.HANG, f"an answer after {seconds:.0f} s on a processor")
            return Finding(*finding)
        except (EOFError, BrokenPipeError, ConnectionResetError):
            self._process.join()
            code = self._process.exitcode or 0
            what = signal.Signals(-code).name if code < 0 else f"exit {code}"
            self._process = None
            return Finding(Outcome.SIGNAL, what)

    def end(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None

    def _begin(self, reader: Callable[[Path], object]) -> None:
        self.end()
        context = mp.get_context("fork")
        self._pipe, theirs = context.Pipe()
        self._reader = reader
        self._process = context.Process(target=_serve, args=(theirs, self._pipe, reader), daemon=True)
        self._process.start()
        theirs.close()


def _serve(pipe: Connection, other_end: Connection, reader: Callable[[Path], object]) -> None:
    other_end.close()
    # What libraries print of a broken file is theirs.
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.dup2(nothing, 2)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("ignore")
    fork_copies()
    while True:
        try:
            path = pipe.recv()
        except EOFError:
            return
        began = _processor_seconds()
        finding = _outcome(reader, path)
        pipe.send((finding, _processor_seconds() - began))


def _processor_seconds() -> float:
    """Of this process and of those that it has begun and that have ended."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def _outcome(reader: Callable[[Path], object], path: Path) -> Finding:
    try:
        reader(path)
    except Exception as error:
        causes, cause = [], error
        while cause is not None:
            causes.append(cause)
            cause = cause.__cause__ or cause.__context__
        message = f"{type(error).__name__}: {error}"[:300]
        where = "; ".join(
            f"{Path(frame.filename).name}:{frame.lineno}"
            for frame in traceback.extract_tb(error.__traceback__)[-2:]
        )
        # A reader that survives a lack of memory has asked for more than the file is worth.
        if any(isinstance(each, MemoryError) for each in causes):
            return Finding(Outcome.MEMORY, message, where)
        return Finding(
            Outcome.REFUSED if isinstance(error, SuppleError) else Outcome.TRACEBACK, message, where
        )
    return Finding(Outcome.GOOD)
