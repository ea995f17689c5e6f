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
"""Processor time of a reader above which the file counts as a hang."""
WAITING = 4
"""Limit of wall time over that of processor time: the computer may be busy, and a reader may sleep."""
MEMORY = 2 * 2**30
"""Limit of the address space beyond that of a process that has not read a file."""


class Outcome(StrEnum):
    """Outcome of reading a file."""

    GOOD = "good"
    REFUSED = "refused"
    TRACEBACK = "traceback"
    MEMORY = "memory"
    SIGNAL = "signal"
    HANG = "hang"

    @property
    def is_fault(self) -> bool:
        """Whether the reader failed; reading a file, or rejecting it with a message, is no fault."""
        return self not in (Outcome.GOOD, Outcome.REFUSED)


class Finding(NamedTuple):
    """An outcome with its message and the line of the sources where it arose."""

    outcome: Outcome
    message: str = ""
    where: str = ""


class Worker:
    """One forked process at a time; after a file that ends it, a new process is started."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process: mp.Process | None = None
        self._pipe: Connection | None = None

    def read(self, reader: Callable[[Path], object], name: str, content: bytes) -> Finding:
        """The outcome for a file with a name and content; the process has `reader` by fork."""
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
                return Finding(Outcome.HANG, f"no result within {WAITING * SECONDS:g} s of wall time")
            finding, seconds = self._pipe.recv()
            if seconds > SECONDS:
                return Finding(Outcome.HANG, f"a result after {seconds:.0f} s of processor time")
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
    # Output of libraries about a broken file is discarded.
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
    """Processor time of this process and of its ended child processes."""
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
        # A reader that catches a lack of memory has allocated too much for the size of the file.
        if any(isinstance(each, MemoryError) for each in causes):
            return Finding(Outcome.MEMORY, message, where)
        return Finding(
            Outcome.REFUSED if isinstance(error, SuppleError) else Outcome.TRACEBACK, message, where
        )
    return Finding(Outcome.GOOD)
