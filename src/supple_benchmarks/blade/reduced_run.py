"""Reduced simulations of the blade with bases of fixed size: those of [Wu2019] Table 2, and a few others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.body import FlexibleBody, FullBody
from supple.integrate import Solution
from supple.reduction import (
    AmplitudeProduct,
    CompressedDerivatives,
    NoDerivatives,
    PickedDerivatives,
    ReducedBody,
    StaticCorrection,
    StaticLoad,
)
from supple.results import MotionError, motion_error
from supple_benchmarks.blade.full_run import FullRun, run_of
from supple_benchmarks.compared_models import FixedBasis, linear_basis, until_early_end
from supple_benchmarks.nrel5mw_blade import BODY, Blade, BladeCase, TipMotion, tip_motion
from supple_benchmarks.progress import Progress

__all__ = ["ReducedRun", "bases_of", "error_against", "run_reduced"]


@dataclass(frozen=True, eq=False)
class ReducedRun:
    """One reduced simulation.

    error : over the time of the full run in the same frame; None without a full run
    failed_at : time of an early end, or None
    """

    case: BladeCase
    basis: FixedBasis
    body: ReducedBody
    solution: Solution
    tip: TipMotion
    error: MotionError | None
    offline_seconds: float
    failed_at: float | None


def bases_of(
    blade: Blade, body: FlexibleBody, frame: str, case: BladeCase, n_linear: int = 50
) -> tuple[FixedBasis, ...]:
    """Five bases: 10 modes with 15 picked derivatives, with 15 compressed ones, with 15 picked ones and plain
    tensors as in [Wu2019]; n_linear columns; 8 modes with 2 static responses and 15 derivatives.

    The static responses of the last basis are those to wind and centrifugal load. Derivatives are weighted by
    the expected loads: the mean wind, and in the last basis also the centrifugal load.
    """
    loads = blade.steady_load(body, case)
    wind = AmplitudeProduct(StaticLoad(loads[:, 0]))
    both = AmplitudeProduct(StaticLoad(loads.sum(axis=1)))
    linear, name = linear_basis(frame, 10), "CB" if frame == "nodal-fixed" else "Rubin"
    many, corrected = linear_basis(frame, n_linear), StaticCorrection(linear_basis(frame, 8), loads)
    picked = PickedDerivatives(15, criterion=wind)
    compressed = CompressedDerivatives(15, weights=wind)
    beyond = PickedDerivatives(15, criterion=both)
    return (
        FixedBasis(frame, linear, name, picked, "picked", "condensed", 10, 15),
        FixedBasis(frame, linear, name, compressed, "compressed", "condensed", 10, 15),
        FixedBasis(frame, linear, name, picked, "picked", "plain", 10, 15),
        FixedBasis(frame, many, name, NoDerivatives(), "none", "plain", n_linear, 0),
        FixedBasis(frame, corrected, f"{name}+static", beyond, "picked", "condensed", 10, 15),
    )


def run_reduced(
    blade: Blade,
    case: BladeCase,
    basis: FixedBasis,
    reduced: tuple[ReducedBody, float],
    full: FullRun | None,
    duration: float,
    progress: Progress,
) -> ReducedRun:
    """Simulate the whole duration, and measure the error over the time of the full run."""
    body, offline_seconds = reduced
    solution, failed_at = until_early_end(
        blade.system(body, case, blade.loads(case, duration)),
        run_of(duration),
        progress=progress,
    )
    return ReducedRun(
        case=case,
        basis=basis,
        body=body,
        solution=solution,
        tip=tip_motion(blade, case, body, solution),
        error=None if full is None else error_against(full.body, full.solution, body, solution),
        offline_seconds=offline_seconds,
        failed_at=failed_at,
    )


def error_against(full_body: FullBody, full: Solution, body: ReducedBody, solution: Solution) -> MotionError:
    """RMS error, [Wu2019] (52), over the time that both runs cover."""
    n = int(np.minimum(len(full.times), len(solution.times)))
    return motion_error(full.at(slice(n)), full_body, solution.at(slice(n)), body, body=BODY)
