"""Other processes of this Python: commands, environment, and available cores."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from threadpoolctl import threadpool_limits

__all__ = ["available_cores", "one_core", "python_command", "python_environment"]

_alone: ContextVar[bool] = ContextVar("alone", default=False)


@contextmanager
def one_core() -> Iterator[None]:
    """Context without further processes or threads of BLAS: parallel work uses the other cores.

    Two processes with two threads each on two cores took 1.4 times as long as with one thread each.
    """
    token = _alone.set(True)
    try:
        with threadpool_limits(1, user_api="blas"):
            yield
    finally:
        _alone.reset(token)


def available_cores() -> int:
    """Number of cores that this process may use."""
    if _alone.get():
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def python_command(*words: str) -> list[str]:
    """Command that starts this Python with its own script or module, not the caller's, which multiprocessing
    would run again. The folder of a script is not an import path."""
    return [sys.executable, "-P", *words]


def python_environment(**variables: str) -> dict[str, str]:
    """Environment of a process that can import the same modules, with further variables."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **variables}
