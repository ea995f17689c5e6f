"""All cores of a processor for many tasks of one kind: processes do what this one has not begun.

JAX runs the programs of a process one after the other where it has one thread, and with more a program alone
takes twice the processor for nothing (`jax_settings`). So the other cores have processes of their own. Those
of a compiled program read it from where it is kept and know nothing else: what it is made of, functions of a
user among them, need not be sent. They are ready in the time that it takes to import JAX.

`concurrent.futures.ProcessPoolExecutor` does not replace them. Its processes import the script of the caller
anew (JAX does not survive a fork), which runs it again unless all it does stands under
`if __name__ == "__main__":`; a batch is called from scripts and notebooks that know nothing of processes.
`sweep`, whose processes are the caller's business, demands that and takes such an executor. A pool also keeps
its caller waiting, which here does tasks like the others, and breaks as a whole with one of its processes.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from queue import SimpleQueue
from threading import Thread
from time import perf_counter
from typing import Any, NamedTuple, Protocol

import jax
import numpy as np

from supple.algebra.available_memory import available_memory
from supple.other_processes import available_cores, python_command, python_environment
from supple.programs import program_worker
from supple.programs.program_cache import CachedProgram

__all__ = ["Finished", "Task", "Work", "on_all_cores", "shared_out"]

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


class Work(Protocol):
    """What is to be done for many arguments, here or by the script of a process that is fed with them."""

    script: str

    def prepare(self, arguments: tuple[Any, ...]) -> None:
        """What the first arguments are needed for, and all others share."""
        ...

    def here(self, arguments: tuple[Any, ...]) -> Any:
        """The result, found by this process."""
        ...

    def greeting(self) -> Any:
        """What a process is sent first, which it answers; None where there can be none."""
        ...

    def question(self, arguments: tuple[Any, ...]) -> Any:
        """What it is sent for some arguments; it answers with seconds and what `result` takes."""
        ...

    def result(self, answer: Any) -> Any:
        """The result."""
        ...


class _ProgramWork:
    """A compiled program."""

    script = program_worker.__file__

    def __init__(self, program: CachedProgram) -> None:
        self._program, self._compiled, self._first = program, None, ()

    def prepare(self, arguments: tuple[Any, ...]) -> None:
        """Compile it."""
        self._first, self._compiled = arguments, self._program.compiled(*arguments)

    def here(self, arguments: tuple[Any, ...]) -> Any:
        """Its result."""
        assert self._compiled is not None
        return jax.device_get(self._compiled(*arguments))

    def greeting(self) -> Any:
        """Where it is kept, and how many leaves go in and come out."""
        assert self._compiled is not None
        file = self._program.file(*self._first)
        if file is None:
            return None
        return str(file), jax.tree.structure(self._first).num_leaves, self._compiled.out_tree.num_leaves

    def question(self, arguments: tuple[Any, ...]) -> Any:
        """Its leaves."""
        return [np.asarray(leaf) for leaf in jax.tree.leaves(arguments)]

    def result(self, answer: Any) -> Any:
        """The tree of the leaves that came out."""
        assert self._compiled is not None
        return jax.tree.unflatten(self._compiled.out_tree, answer)


def on_all_cores(program: CachedProgram, tasks: Sequence[Task]) -> Iterator[Finished]:
    """Run a program for many arguments, which agree in all but numbers; what comes first is given first."""
    return shared_out(_ProgramWork(program), tasks)


def shared_out(work: Work, tasks: Sequence[Task]) -> Iterator[Finished]:
    """Work for many arguments; what is finished first is given first.

    The time of the first one predicts the others, and what number of processes is worth it: none where they
    are over soon, where no process can do the work, on other devices than a processor. What a process that
    ends before its time has left undone, this one does.
    """
    waiting = deque(range(len(tasks)))
    number = _next(waiting)
    if number is None:
        return
    arguments = tasks[number]()
    work.prepare(arguments)

    def finished_here(number: int, arguments: tuple[Any, ...]) -> Finished:
        began = perf_counter()
        result = work.here(arguments)
        return Finished(number, perf_counter() - began, result)

    first = finished_here(number, arguments)
    yield first
    done: SimpleQueue[Finished | None] = SimpleQueue()
    workers = _workers(work, _number_worth(first.seconds * len(waiting), len(waiting)))
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
    """A process that does some work, and is asked to by a thread."""

    def __init__(self, work: Work, greeting: Any) -> None:
        self._work, self._greeting = work, greeting
        self._process = subprocess.Popen(
            python_command(work.script),
            env=python_environment(JAX_ENABLE_X64="1", JAX_PLATFORMS="cpu"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._thread: Thread | None = None

    def begin(self, *work: Any) -> None:
        """Have it do what waits until nothing does; None at the end, and whatever it fails at waits again."""
        self._thread = Thread(target=self._feed, args=work, daemon=True)
        self._thread.start()

    def _feed(self, tasks: Sequence[Task], waiting: deque[int], done: SimpleQueue[Finished | None]) -> None:
        number = None
        try:
            self._ask(self._greeting)
            while (number := _next(waiting)) is not None:
                seconds, answer = self._ask(self._work.question(tasks[number]()))
                done.put(Finished(number, seconds, self._work.result(answer)))
        except Exception:  # whatever it is, this process does the task or meets the same
            if number is not None:
                waiting.append(number)
        finally:
            done.put(None)

    def _ask(self, question: Any) -> Any:
        request, response = self._process.stdin, self._process.stdout
        assert request is not None
        assert response is not None
        pickle.dump(question, request, pickle.HIGHEST_PROTOCOL)
        request.flush()
        return pickle.load(response)

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


def _workers(work: Work, number: int) -> list[_Worker]:
    """As many as can be started."""
    workers: list[_Worker] = []
    greeting = work.greeting() if number else None
    if greeting is None or not sys.executable:
        return workers
    with suppress(OSError):  # no more processes are to be had
        for _ in range(number):
            workers.append(_Worker(work, greeting))
    return workers
