"""Many tasks of one kind on all cores of a processor: worker processes take tasks that are not started yet.

With one thread, JAX runs the programs of a process one after the other. With more threads, a single program
uses twice the processor time without benefit (`jax_settings`). The other cores therefore get processes of
their own. A worker for a compiled program reads the program from the cache and needs nothing else: the
functions in it, also a user's, need not be sent. The worker is ready as soon as JAX is imported.

`concurrent.futures.ProcessPoolExecutor` is not used here. Its processes must be spawned, because JAX does not
survive a fork. A spawned process runs the script of the caller again, except statements below
`if __name__ == "__main__":`; scripts and notebooks that call a batch may lack this line. (`sweep`, where the
caller provides the processes, requires the line and accepts such an executor.) A pool also blocks its caller,
which here computes tasks as well. If one process of a pool fails, the whole pool fails.
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
from supple.blas_threads import one_blas_thread
from supple.other_processes import available_cores, python_command, python_environment
from supple.programs import program_worker
from supple.programs.program_cache import Arguments, CachedProgram

_WORTH = 3.0
"""Seconds of remaining work per process started: starting one takes more than one second."""
_MEMORY = 2**29
"""Bytes per process, including the data sent to it."""

Task = Callable[[], Arguments]
"""Returns the arguments of the program; called when the task starts."""


class Finished(NamedTuple):
    """A finished task."""

    number: int
    seconds: float
    """Run time of the program"""
    result: Any


class Work(Protocol):
    """Work for many arguments, done in this process or by a worker script."""

    script: str

    def prepare(self, arguments: Arguments) -> None:
        """Prepare what all tasks share, with the first arguments."""
        ...

    def here(self, arguments: Arguments) -> Any:
        """The result, computed in this process."""
        ...

    def greeting(self) -> Any:
        """First message to a worker, which confirms its receipt; None where no worker can be used."""
        ...

    def question(self, arguments: Arguments) -> Any:
        """Message with the arguments of a task; the worker replies with seconds and the input of `result`."""
        ...

    def result(self, answer: Any) -> Any:
        """The result from a worker's reply."""
        ...


class _ProgramWork:
    """Execution of a compiled program: a worker has its file, and exchanges the leaves of its trees."""

    script = program_worker.__file__

    def __init__(self, program: CachedProgram) -> None:
        self._program, self._compiled, self._first = program, None, ()

    def prepare(self, arguments: Arguments) -> None:
        """Compile the program, or load it from the cache."""
        self._first, self._compiled = arguments, self._program.compiled(*arguments)

    def here(self, arguments: Arguments) -> Any:
        """The result of the compiled program, on one thread."""
        assert self._compiled is not None
        with one_blas_thread():
            return jax.device_get(self._compiled(*arguments))

    def greeting(self) -> Any:
        """File of the program with the numbers of leaves in and out; None where it has no file."""
        assert self._compiled is not None
        file = self._program.file(*self._first)
        if file is None:
            return None
        return str(file), jax.tree.structure(self._first).num_leaves, self._compiled.out_tree.num_leaves

    def question(self, arguments: Arguments) -> Any:
        """The leaves of the arguments."""
        return [np.asarray(leaf) for leaf in jax.tree.leaves(arguments)]

    def result(self, answer: Any) -> Any:
        """The tree of results from its leaves."""
        assert self._compiled is not None
        return jax.tree.unflatten(self._compiled.out_tree, answer)


def on_all_cores(program: CachedProgram, tasks: Sequence[Task]) -> Iterator[Finished]:
    """Run a program for many arguments that differ in numbers only; results in order of completion."""
    return shared_out(_ProgramWork(program), tasks)


def shared_out(work: Work, tasks: Sequence[Task]) -> Iterator[Finished]:
    """Work for many arguments on all cores; results in order of completion.

    The time of the first task predicts the remaining time, and with it the useful number of processes. No
    process is started if the remaining time is short, if no worker can do the work, or on devices other than
    a CPU. If a worker ends early, its unfinished task returns to the queue, for any worker or this process.
    """
    waiting = deque(range(len(tasks)))
    number = _next(waiting)
    if number is None:
        return
    arguments = tasks[number]()
    work.prepare(arguments)

    def finished_here(number: int, arguments: Arguments) -> Finished:
        """A task done in this process."""
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
                    break  # a worker may have left a task unfinished
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
    """A worker process, and the thread that sends it tasks."""

    def __init__(self, work: Work, greeting: Any) -> None:
        self._work, self._greeting = work, greeting
        self._process = subprocess.Popen(
            python_command(work.script),
            env=python_environment(JAX_ENABLE_X64="1", JAX_PLATFORMS="cpu", OPENBLAS_NUM_THREADS="1"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._thread: Thread | None = None

    def begin(self, *work: Any) -> None:
        """Do waiting tasks until none is left, then report None; a failed task is put back in the queue."""
        self._thread = Thread(target=self._feed, args=work, daemon=True)
        self._thread.start()

    def _feed(self, tasks: Sequence[Task], waiting: deque[int], done: SimpleQueue[Finished | None]) -> None:
        number = None
        try:
            self._ask(self._greeting)
            while (number := _next(waiting)) is not None:
                seconds, answer = self._ask(self._work.question(tasks[number]()))
                done.put(Finished(number, seconds, self._work.result(answer)))
        except Exception:  # of any kind: another worker or this process repeats the task
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
        """End the process at once, and the thread."""
        self._process.kill()
        if self._thread is not None:
            self._thread.join()
        self._process.communicate()


def _number_worth(seconds: float, n_tasks: int) -> int:
    """Useful number of processes beside this one for a total time and a number of tasks."""
    memory = available_memory()
    most = n_tasks if memory is None else min(n_tasks, memory // _MEMORY)
    return min(available_cores() - 1, most, int(seconds / _WORTH))


def _workers(work: Work, number: int) -> list[_Worker]:
    """Start workers, as many as possible."""
    workers: list[_Worker] = []
    greeting = work.greeting() if number else None
    if greeting is None or not sys.executable:
        return workers
    with suppress(OSError):  # no further processes are available
        for _ in range(number):
            workers.append(_Worker(work, greeting))
    return workers
