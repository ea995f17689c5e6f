"""Load cases by a process that is fed with them; as a script it is that process (`worker_processes`)."""

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
    """`Work` of runs, whose arguments are a machine each."""

    script = __file__

    def __init__(self, run: Run) -> None:
        self._run = run

    def prepare(self, arguments: tuple[Any, ...]) -> None:
        """Nothing: the first run compiles what all share."""

    def here(self, arguments: tuple[Any, ...]) -> Solution:
        """The motion of a case."""
        return _marched(self.question(arguments), self._run)

    def greeting(self) -> Run:
        """The run."""
        return self._run

    def question(self, arguments: tuple[Any, ...]) -> System:
        """The machine."""
        (system,) = arguments
        return system

    def result(self, answer: tuple[dict[str, Any], list[Any]]) -> Solution:
        """The motion; what its run warned of is warned of here."""
        parts, warned = answer
        for message in warned:
            warnings.warn(message, stacklevel=2)
        return Solution(**parts)


def _marched(system: System, run: Run) -> Solution:
    from supple.simulation.watched_run import watched_run

    return watched_run(system, run, check=False)


def answer(questions: BinaryIO, answers: BinaryIO) -> None:
    """Run all that is asked."""
    run = pickle.load(questions)
    _say("ready", answers)
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
        _say((perf_counter() - began, (parts, [each.message for each in caught])), answers)


def _plain(value: Any) -> Any:
    """A mapping that can be sent."""
    return dict(value) if isinstance(value, Mapping) else value


def _say(answered: Any, answers: BinaryIO) -> None:
    pickle.dump(answered, answers, pickle.HIGHEST_PROTOCOL)
    answers.flush()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the process that asks, which closes the input
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as own:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # whatever libraries say
        answer(sys.stdin.buffer, own)
