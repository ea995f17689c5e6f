"""Simulation of load cases in worker processes; a worker process runs this file as its script."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any

from supple.integrate import Run, Solution
from supple.machine import System
from supple.programs.program_worker import serve

Answer = tuple[dict[str, Any], list[Warning | str]]
"""Fields of a solution, and the warnings of its run"""


class CaseWork:
    """`Work` that runs one machine per task."""

    script = __file__

    def __init__(self, run: Run) -> None:
        self._run = run

    def prepare(self, arguments: tuple[System]) -> None:
        """No preparation: the first run compiles the common program."""

    def here(self, arguments: tuple[System]) -> Solution:
        """The motion of a case, computed in the process of the caller."""
        return _marched(self.question(arguments), self._run)

    def greeting(self) -> Run:
        """The run, sent to the worker once before the cases."""
        return self._run

    def question(self, arguments: tuple[System]) -> System:
        """The machine, sent for each case."""
        (system,) = arguments
        return system

    def result(self, answer: Answer) -> Solution:
        """The motion from the answer of a worker; warnings of the run are issued again in this process."""
        parts, warned = answer
        for message in warned:
            warnings.warn(message, stacklevel=2)
        return Solution(**parts)


def _marched(system: System, run: Run) -> Solution:
    from supple.simulation.watched_run import watched_run

    return watched_run(system, run, check=False)


def marcher_of(run: Run) -> Callable[[System], Answer]:
    """Function that runs a machine."""

    def answer(system: System) -> Answer:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            solution = _marched(system, run)
        parts = {each.name: getattr(solution, each.name) for each in fields(solution)}
        # Mappings become dictionaries, which can be pickled.
        plain = {name: dict(own) if isinstance(own, Mapping) else own for name, own in parts.items()}
        return plain, [each.message for each in caught]

    return answer


if __name__ == "__main__":
    serve(marcher_of)
