"""Load cases of the blade in one call: the same blade and machine, turbulence of different seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

import jax
import numpy as np

from supple.errors import AccuracyError
from supple.integrate import FloatingMotion
from supple.reduction import ReducedBody
from supple.simulation import simulate, simulate_batch
from supple_benchmarks.blade.full_run import run_of
from supple_benchmarks.nrel5mw_blade import BODY, Blade, BladeCase
from supple_benchmarks.progress import Progress

__all__ = ["BatchRun", "run_batch"]

LARGEST_DIFFERENCE = 1e-10


@dataclass(frozen=True)
class BatchRun:
    """Cost of a batch.

    seconds : time of the batch after compilation; single_seconds : mean time of a case alone
    total_seconds : time of the batch with compilation
    largest_difference : of the coordinates between a case in the batch and the same case alone, over the
        largest coordinate, for the cases that are also run alone
    """

    cases: int
    size: int
    duration: float
    seconds: float
    single_seconds: float
    total_seconds: float
    largest_difference: float
    cases_checked_alone: int
    device: str

    @property
    def cases_per_s(self) -> float:
        """Cases per second after compilation."""
        return self.cases / self.seconds


def run_batch(
    blade: Blade,
    case: BladeCase,
    body: ReducedBody,
    seeds: Sequence[int],
    duration: float,
    progress: Progress,
) -> BatchRun:
    """Simulate one case per seed through one compiled call, and some of them separately for comparison.

    Raises
    ------
    ConvergenceError    a case failed
    AccuracyError       a case in the batch differs from the same case alone
    """
    systems = [blade.system(body, case, blade.loads(case, duration, seed=seed)) for seed in seeds]
    run = run_of(duration)
    began = perf_counter()
    together = simulate_batch(systems, run, progress=lambda share: progress(0.8 * share)).check()
    total = perf_counter() - began
    checked = sorted({0, len(seeds) // 2, len(seeds) - 1})
    differences, seconds = [], []
    for done, number in enumerate(checked, start=1):
        alone = simulate(systems[number], run)
        one, other = (
            solution.motion(BODY, FloatingMotion).coordinates
            for solution in (alone, together.solutions[number])
        )
        differences.append(float(abs(one - other).max() / abs(one).max()))
        seconds.append(alone.statistics.seconds)
        progress(0.8 + 0.2 * done / len(checked))
    if max(differences) > LARGEST_DIFFERENCE:
        raise AccuracyError(
            f"cases simulated in a batch and alone differ by {max(differences):.1e} of the motion "
            f"(allowed {LARGEST_DIFFERENCE:.0e})"
        )
    return BatchRun(
        cases=len(seeds),
        size=body.r,
        duration=duration,
        seconds=together.seconds,
        single_seconds=float(np.mean(seconds)),
        total_seconds=total,
        largest_difference=max(differences),
        cases_checked_alone=len(checked),
        device=jax.devices()[0].platform,
    )
