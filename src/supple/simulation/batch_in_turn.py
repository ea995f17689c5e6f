"""Load cases that cannot run together in one compiled program: each is simulated separately."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from functools import partial
from typing import Any

import jax
import numpy as np

from supple.algebra.available_memory import require_memory
from supple.errors import ModelError
from supple.integrate import Progress, Run
from supple.machine import System
from supple.methods.floating.compiled.batch_start import Axes
from supple.programs.worker_processes import shared_out
from supple.simulation.batch_solution import BatchSolution
from supple.simulation.case_worker import CaseWork


def batch_in_turn(cases: Sequence[System], run: Run, progress: Progress | None) -> BatchSolution:
    """Simulate each case separately, as by `simulate(check=False)`, on all cores if that is faster.

    Raises ModelError for cases with other bodies, joints or kinds of loads than the first case.
    """
    for number, system in enumerate(cases):
        if _kinds(system) != _kinds(cases[0]):
            raise ModelError(
                f"case {number} differs from the first in more than numbers: the cases of a batch have the "
                "same bodies, joints and kinds of loads"
            )
    began, found = clock.perf_counter(), {}
    # The processes receive the cases pickled; cases that cannot be pickled run in this process.
    for done in shared_out(CaseWork(run), [partial(tuple, [system]) for system in cases]):
        found[done.number] = done.result
        if progress is not None:
            progress(len(found) / len(cases))
    solutions = [found[number] for number in range(len(cases))]
    failures = {number: own.stopped for number, own in enumerate(solutions) if own.stopped is not None}
    passed = clock.perf_counter() - began
    # The run times exclude compilation. The sum for parallel cases can exceed the elapsed time.
    seconds = min(passed, sum(own.statistics.seconds for own in solutions))
    return BatchSolution(tuple(solutions), failures, seconds, passed - seconds)


def require_memory_of_chunk(model: Any, axes: Axes, state: Any, chunk: int, n_times: int, more: int) -> None:
    """MemoryShortageError where a chunk of cases would exceed the available memory.

    model, state : of one case; numbers of the model without an axis are stored once
    more : numbers of each case beside its model and history
    """
    leaves = zip(jax.tree.leaves(model), axes, strict=True)
    numbers = sum(np.size(leaf) * (1 if axis is None else chunk) for leaf, axis in leaves)
    history = 3 * n_times * sum(np.size(leaf) for leaf in jax.tree.leaves(state))
    require_memory(
        8 * (2 * numbers + chunk * (history + more)),
        f"a chunk of {chunk} cases with {n_times} output times",
        "use fewer cases at a time (`chunk`) or fewer output times",
    )


def _kinds(system: System) -> list[tuple[str, ...]]:
    bodies = [
        (placed.body.kind, placed.body.name, str(placed.body.n_coordinates)) for placed in system.bodies
    ]
    joints = [(type(joint).__name__, joint.name) for joint in system.joints]
    return [*bodies, *joints, *((type(load).__name__,) for load in system.loads)]
