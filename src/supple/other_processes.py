"""Other processes of this Python: how they are started, and the cores there are for them."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

__all__ = ["available_cores", "one_core", "python_command", "python_environment"]

_alone: ContextVar[bool] = ContextVar("alone", default=False)


@contextmanager
def one_core() -> Iterator[None]:
    """Work that starts no processes of its own: those beside it have the other cores."""
    token = _alone.set(True)
    try:
        yield
    finally:
        _alone.reset(token)


def available_cores() -> int:
    """How many cores this process may use."""
    if _alone.get():
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def python_command(*words: str) -> list[str]:
    """What starts this Python with a script or a module of its own: not the caller's, which multiprocessing
    would run again. The folder of a script is no place to import from."""
    return [sys.executable, "-P", *words]


def python_environment(**variables: str) -> dict[str, str]:
    """The environment of a process that imports what this one can, with more variables."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **variables}
