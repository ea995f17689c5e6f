"""Self-correction of the blade, from 5 modes and 5 derivatives to a target error, against the full run."""

from __future__ import annotations

from dataclasses import dataclass

from supple.body import FlexibleBody, FullBody, RayleighDamping
from supple.error import ReductionStart, Round, SelfCorrection, SelfCorrectionError, self_correct
from supple.reduction import AmplitudeProduct, CompressedDerivatives, CraigBampton, StaticLoad
from supple_benchmarks.blade.full_run import FullRun, run_of
from supple_benchmarks.blade.reduced_run import error_against
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.nrel5mw_blade import Blade, BladeCase
from supple_benchmarks.progress import Progress

__all__ = ["CorrectedRun", "correct_blade"]


@dataclass(frozen=True, eq=False)
class CorrectedRun:
    """The rounds of a self-correction, with true errors.

    allowed : float                 the target error, m
    reached : bool                  whether the target was reached
    true_errors : (k,) | None       largest RMS error of each round against the full run of the same frame,
                                    over the same time; None without a full run
    """

    case: BladeCase
    frame: str
    allowed: float
    reached: bool
    rounds: tuple[Round, ...]
    true_errors: tuple[float, ...] | None


def correct_blade(
    blade: Blade,
    body: FlexibleBody,
    damping: RayleighDamping,
    case: BladeCase,
    frame: str,
    *,
    allowed: float,
    duration: float,
    full: FullRun | None,
    progress: Progress,
) -> CorrectedRun:
    """Reduce the blade to the allowed error without the full run, then compare with it."""
    wind = AmplitudeProduct(StaticLoad(blade.steady_load(body, case)[:, 0]))
    loads = blade.loads(case, duration)
    found: list[Round] = []

    def finished(round_: Round) -> None:
        found.append(round_)
        progress(len(found) / (len(found) + 1))

    try:
        start = ReductionStart(
            SelfCorrection(absolute=allowed, max_rounds=MAX_ROUNDS),
            CraigBampton(n_modes=5),
            CompressedDerivatives(5, weights=wind),
        )
        system = blade.system(FullBody(body, FRAMES[frame], damping), case, loads)
        self_correct(system, run_of(duration), start, announce=finished)
        reached = True
    except SelfCorrectionError:
        # An error that is not reached is a result of this benchmark, and is reported.
        reached = False
    progress(1.0)
    truth = None
    if full is not None:
        truth = tuple(
            error_against(full.body, full.solution, each.body, each.solution).max_rms for each in found
        )
    return CorrectedRun(case, frame, allowed, reached, tuple(found), truth)


MAX_ROUNDS = 5
