"""Simulation of load cases in worker processes; a worker process runs this file as its script."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import warnings
from collections.abc import Mapping
from dataclasses import fields
from time import perf_counter
from typing import Any, BinaryIO

from supple.integrate import Run, Solution
from supple.machine import System

__all__ = ["CaseWork"]


class CaseWork:
    """`Work` that runs one machine per task."""

    script = __file__

    def __init__(self, run: Run) -> None:
        self._run = run

    def prepare(self, arguments: tuple[Any, ...]) -> None:
        """No preparation: the first run compiles the common program."""

    def here(self, arguments: tuple[Any, ...]) -> Solution:
        """The motion of a case, computed in the process of the caller."""
        return _marched(self.question(arguments), self._run)

    def greeting(self) -> Run:
        """The run, sent to the worker once before the cases."""
        return self._run

    def question(self, arguments: tuple[Any, ...]) -> System:
        """The machine, sent for each case."""
        (system,) = arguments
        return system

    def result(self, answer: tuple[dict[str, Any], list[Any]]) -> Solution:
        """The motion from the answer of a worker; warnings of the run are issued again in this process."""
        parts, warned = answer
        for message in warned:
            warnings.warn(message, stacklevel=2)
        return Solution(**parts)


def _marched(system: System, run: Run) -> Solution:
    from supple.simulation.watched_run import watched_run

    return watched_run(system, run, check=False)


def answer_cases(questions: BinaryIO, answers: BinaryIO) -> None:
    """Receive a run and cases, and answer each case with its elapsed time, motion and warnings."""
    run = pickle.load(questions)
    _send("ready", answers)
    while True:
        try:
            system = pickle.load(questions)
        except EOFError:
            return
        began = perf_counter()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            solution = _marched(system, run)
        parts = {each.name: _plain(getattr(solution, each.name)) for each in fields(solution)}
        _send((perf_counter() - began, (parts, [each.message for each in caught])), answers)


def _plain(value: Any) -> Any:
    """The value; a mapping as a dictionary, which can be pickled."""
    return dict(value) if isinstance(value, Mapping) else value


def _send(result: Any, answers: BinaryIO) -> None:
    pickle.dump(result, answers, pickle.HIGHEST_PROTOCOL)
    answers.flush()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # handled by the parent process, which closes the input
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as own:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # output of libraries
        answer_cases(sys.stdin.buffer, own)
