"""Other processes and threads of this Python: commands, environment, and available cores."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

_Given = TypeVar("_Given")
_Found = TypeVar("_Found")
_alone: ContextVar[bool] = ContextVar("alone", default=False)


@contextmanager
def one_core() -> Iterator[None]:
    """Context in which `available_cores` returns 1, because parallel processes use the other cores."""
    token = _alone.set(True)
    try:
        yield
    finally:
        _alone.reset(token)


def available_cores() -> int:
    """Number of cores that this process may use."""
    if _alone.get():
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_threads(function: Callable[[_Given], _Found], arguments: Sequence[_Given]) -> list[_Found]:
    """Results of a function for each argument, in order, computed by threads on the available cores."""
    number = min(available_cores(), len(arguments))
    if number < 2:
        return [function(each) for each in arguments]
    with ThreadPoolExecutor(number) as pool:
        return list(pool.map(function, arguments))


def python_command(*words: str) -> list[str]:
    """Command that runs a script or module in this Python.

    `multiprocessing` would also run the script of the caller again. The folder of the script is not on the
    import path (-P).
    """
    return [sys.executable, "-P", *words]


def python_environment(**variables: str) -> dict[str, str]:
    """Environment of a process that can import the same modules as this one, with further variables."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **variables}
