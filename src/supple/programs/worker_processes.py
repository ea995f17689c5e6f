"""All cores of a processor for one compiled program: processes that run it on what this one has not begun.

JAX runs the programs of a process one after the other where it has one thread, and with more a program alone
takes twice the processor for nothing (`jax_settings`). So the other cores have processes of their own. They
read the program from where it is kept and know nothing else: what it is made of, functions of a user among
them, need not be sent. They are ready in the time that it takes to import JAX.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from time import perf_counter
from typing import Any, NamedTuple

import jax
import numpy as np

from supple.algebra.available_memory import available_memory
from supple.other_processes import available_cores, python_command, python_environment
from supple.programs import program_worker
from supple.programs.kept_programs import KeptProgram

__all__ = ["Finished", "Task", "on_all_cores"]

_WORTH = 3.0
"""Seconds of work left for each process that is started: it takes more than one to be ready."""
_MEMORY = 2**29
"""Bytes of a process, with what it is sent."""

Task = Callable[[], tuple[Any, ...]]
"""The arguments of the program, made when it is their turn."""


class Finished(NamedTuple):
    """A task that is done."""

    number: int
    seconds: float
    """That the program ran."""
    result: Any


def on_all_cores(program: KeptProgram, tasks: Sequence[Task]) -> Iterator[Finished]:
    """Run a program for many arguments, which agree in all but numbers; what comes first is given first.

    The first one tells how long the others will take, and how many processes are worth it: none where they
    are over soon, where the program is not kept, on other devices than a processor. What a process that ends
    before its time has left undone, this one does.
    """
    waiting = deque(range(len(tasks)))
    number = _next(waiting)
    if number is None:
        return
    arguments = tasks[number]()
    compiled = program.compiled(*arguments)

    def finished_here(number: int, arguments: tuple[Any, ...]) -> Finished:
        began = perf_counter()
        result = jax.device_get(compiled(*arguments))
        return Finished(number, perf_counter() - began, result)

    first = finished_here(number, arguments)
    yield first
    done: SimpleQueue[Finished | None] = SimpleQueue()
    workers = _workers(
        program.file(*arguments),
        jax.tree.structure(arguments).num_leaves,
        compiled.out_tree,
        _number_worth(first.seconds * len(waiting), len(waiting)),
    )
    try:
        for worker in workers:
            worker.begin(tasks, waiting, done)
        at_work = len(workers)
        while waiting or at_work:
            number = _next(waiting)
            if number is not None:
                yield finished_here(number, tasks[number]())
            while at_work and (number is None or not done.empty()):
                finished = done.get()
                if finished is None:
                    at_work -= 1
                    break  # perhaps it has left something undone
                yield finished
    finally:
        for worker in workers:
            worker.end()


def _next(waiting: deque[int]) -> int | None:
    try:
        return waiting.popleft()
    except IndexError:
        return None


class _Worker:
    """A process that runs a program, and is asked to by a thread."""

    def __init__(self, file: Path, n_arguments: int, given: Any) -> None:
        self._given = given
        self._process = subprocess.Popen(
            python_command(program_worker.__file__),
            env=python_environment(JAX_ENABLE_X64="1", JAX_PLATFORMS="cpu"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._program = str(file), n_arguments, given.num_leaves
        self._thread: Thread | None = None

    def begin(self, *work: Any) -> None:
        """Have it do what waits until nothing does; None at the end, and whatever it fails at waits again."""
        self._thread = Thread(target=self._feed, args=work, daemon=True)
        self._thread.start()

    def _feed(self, tasks: Sequence[Task], waiting: deque[int], done: SimpleQueue[Finished | None]) -> None:
        number = None
        try:
            self._ask(self._program)
            while (number := _next(waiting)) is not None:
                seconds, leaves = self._ask([np.asarray(leaf) for leaf in jax.tree.leaves(tasks[number]())])
                done.put(Finished(number, seconds, jax.tree.unflatten(self._given, leaves)))
        except Exception:  # whatever it is, this process does the task or meets the same
            if number is not None:
                waiting.append(number)
        finally:
            done.put(None)

    def _ask(self, question: Any) -> Any:
        ask, hear = self._process.stdin, self._process.stdout
        assert ask is not None
        assert hear is not None
        pickle.dump(question, ask, pickle.HIGHEST_PROTOCOL)
        ask.flush()
        return pickle.load(hear)

    def end(self) -> None:
        """Of the process, at once, and of the thread."""
        self._process.kill()
        if self._thread is not None:
            self._thread.join()
        self._process.communicate()


def _number_worth(seconds: float, n_tasks: int) -> int:
    """Of processes beside this one, for so much work in so many tasks."""
    memory = available_memory()
    most = n_tasks if memory is None else min(n_tasks, memory // _MEMORY)
    return min(available_cores() - 1, most, int(seconds / _WORTH))


def _workers(file: Path | None, n_arguments: int, given: Any, number: int) -> list[_Worker]:
    """As many as can be started."""
    workers: list[_Worker] = []
    if file is None or not sys.executable:
        return workers
    with suppress(OSError):  # no more processes are to be had
        for _ in range(number):
            workers.append(_Worker(file, n_arguments, given))
    return workers
