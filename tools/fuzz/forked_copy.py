"""Copies of HDF5 files by a forked process instead of a new one: the same code, without the imports.

Only for fuzzing, where no threads run.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import time

from supple import copied_hdf5


def fork_copies() -> None:
    """Make this process fork the processes that copy."""
    copied_hdf5._answer = _answer


def _answer(words: list[str], seconds: float) -> tuple[int | None, str]:
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        try:
            os.dup2(writing, 1)
            sys.stdout = os.fdopen(1, "w", encoding="utf-8", errors="replace")
            status = copied_hdf5.copy_within_limits(*words)
            sys.stdout.flush()
        except BaseException:
            os._exit(1)
        os._exit(status)
    os.close(writing)
    output, end = b"", time.monotonic() + seconds
    try:
        while select.select([reading], [], [], max(0.0, end - time.monotonic()))[0]:
            piece = os.read(reading, 65536)
            if not piece:
                break
            output += piece
        else:
            os.kill(child, signal.SIGKILL)
            return None, ""
    finally:
        os.close(reading)
        _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), output.decode(errors="replace").strip()
