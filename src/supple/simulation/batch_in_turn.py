"""Load cases that no program marches together, one after another."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence

from supple.errors import ModelError
from supple.integrate import Progress, Run
from supple.machine import System
from supple.simulation.batch_solution import BatchSolution
from supple.simulation.watched_run import watched_run

__all__ = ["batch_in_turn"]


def batch_in_turn(cases: Sequence[System], run: Run, progress: Progress | None) -> BatchSolution:
    """The solutions of `simulate`, case by case: the first compiles what all of one structure share.

    Raises ModelError for cases of other bodies, joints or kinds of loads than the first.
    """
    for number, system in enumerate(cases):
        if _kinds(system) != _kinds(cases[0]):
            raise ModelError(
                f"case {number} differs from the first in more than numbers: the cases of a batch have the "
                "same bodies, joints and kinds of loads"
            )
    began, solutions = clock.perf_counter(), []
    for system in cases:
        solutions.append(watched_run(system, run, check=False))
        if progress is not None:
            progress(len(solutions) / len(cases))
    failures = {number: own.stopped for number, own in enumerate(solutions) if own.stopped is not None}
    seconds = sum(own.statistics.seconds for own in solutions)
    return BatchSolution(tuple(solutions), failures, seconds, clock.perf_counter() - began - seconds)


def _kinds(system: System) -> list[tuple[str, ...]]:
    bodies = [
        (placed.body.kind, placed.body.name, str(placed.body.n_coordinates)) for placed in system.bodies
    ]
    joints = [(type(joint).__name__, joint.name) for joint in system.joints]
    return [*bodies, *joints, *((type(load).__name__,) for load in system.loads)]
