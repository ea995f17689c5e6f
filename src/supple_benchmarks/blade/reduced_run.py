"""Reduced simulations of the blade with bases of fixed size: those of [Wu2019] Table 2, and a few others."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from supple.body import FlexibleBody, FullBody, RayleighDamping
from supple.integrate import Run, Solution
from supple.reduction import (
    AmplitudeProduct,
    CompressedDerivatives,
    CraigBampton,
    DerivativeChoice,
    LinearBasisRecipe,
    NoDerivatives,
    PickedDerivatives,
    ReducedBody,
    Rubin,
    StaticCorrection,
    StaticLoad,
)
from supple.results import MotionError, motion_error
from supple_benchmarks.blade.full_run import OUTPUT_STEP, STEP, TOLERANCES, FullRun
from supple_benchmarks.compared_tensors import reduce_to_compare
from supple_benchmarks.nrel5mw_blade import BODY, FRAMES, Blade, BladeCase, TipMotion, tip_motion
from supple_benchmarks.progress import Progress
from supple_benchmarks.until_early_end import until_early_end

__all__ = ["FixedBasis", "ReducedRun", "bases_of", "error_against", "reduce_blade", "run_reduced"]


@dataclass(frozen=True, eq=False)
class FixedBasis:
    """A basis of fixed size, and its names and numbers in the report."""

    frame: str
    recipe: LinearBasisRecipe
    name: str
    derivatives: DerivativeChoice
    derivatives_name: str
    tensors: str
    n_linear: int
    n_added: int

    @property
    def label(self) -> str:
        """Label for tables and legends."""
        if not self.n_added:
            return f"{self.name} {self.n_linear}"
        plain = ", plain" if self.tensors == "plain" else ""
        return f"{self.name} {self.n_linear}+{self.n_added} {self.derivatives_name}{plain}"


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

    def linear(n_columns: int) -> LinearBasisRecipe:
        return CraigBampton(n_modes=n_columns) if frame == "nodal-fixed" else Rubin(n_columns=n_columns)

    name = "CB" if frame == "nodal-fixed" else "Rubin"
    corrected = StaticCorrection(linear(8), loads)
    picked = PickedDerivatives(15, criterion=wind)
    compressed = CompressedDerivatives(15, weights=wind)
    beyond = PickedDerivatives(15, criterion=both)
    return (
        FixedBasis(frame, linear(10), name, picked, "picked", "condensed", 10, 15),
        FixedBasis(frame, linear(10), name, compressed, "compressed", "condensed", 10, 15),
        FixedBasis(frame, linear(10), name, picked, "picked", "plain", 10, 15),
        FixedBasis(frame, linear(n_linear), name, NoDerivatives(), "none", "plain", n_linear, 0),
        FixedBasis(frame, corrected, f"{name}+static", beyond, "picked", "condensed", 10, 15),
    )


def reduce_blade(
    body: FlexibleBody, basis: FixedBasis, damping: RayleighDamping
) -> tuple[ReducedBody, float]:
    """The reduced blade and the time of the reduction in seconds."""
    began = perf_counter()
    reduced = reduce_to_compare(
        body,
        FRAMES[basis.frame],
        basis.recipe,
        derivatives=basis.derivatives,
        tensors=basis.tensors,
        damping=damping,
    )
    return reduced, perf_counter() - began


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
        Run(duration=duration, output_step=OUTPUT_STEP, step=STEP, tolerances=TOLERANCES),
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
