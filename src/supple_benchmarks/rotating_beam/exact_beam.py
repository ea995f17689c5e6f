"""The tip of the geometrically exact beam, with the step halved until the whole history converges."""

from __future__ import annotations

from dataclasses import dataclass

from supple.errors import ConvergenceError
from supple.machine.laws.spin_up import SpinUp
from supple_benchmarks.beam_motion import spin_up_beam
from supple_benchmarks.planar_beam import ROTATING_BEAM
from supple_benchmarks.rotating_beam.problem import RotatingBeam
from supple_benchmarks.rotating_beam.tip_motion import TipMotion, apart

__all__ = ["CONVERGED", "ExactTip", "exact_tip"]

CONVERGED = 2e-5
"""m: largest change of the tip position, at any time, when the step is halved."""
MOST_HALVINGS = 5


@dataclass(frozen=True)
class ExactTip(TipMotion):
    """A converged tip motion.

    step : float            s, the smallest step
    converged_within : float    m, largest change by the last halving, at any time
    at_the_models_step : TipMotion      the same beam with the step of the full and reduced models
    """

    step: float
    converged_within: float
    at_the_models_step: TipMotion


def exact_tip(problem: RotatingBeam, spin: SpinUp) -> ExactTip:
    """Tip of the exact beam by Richardson's extrapolation of steps h and h/2.

    Both steps are halved until two successive extrapolations agree.

    The method is of second order: (4 x_(h/2) - x_h) / 3. Twenty elements are within 1e-6 m of forty.

    Raises ConvergenceError if MOST_HALVINGS halvings of the models' step do not reach CONVERGED.
    """
    step = problem.step
    first = coarse = _tip(problem, spin, step)
    before, change = None, float("inf")
    for _ in range(MOST_HALVINGS):
        step /= 2
        fine = _tip(problem, spin, step)
        now = TipMotion(fine.times, fine.u + (fine.u - coarse.u) / 3, fine.v + (fine.v - coarse.v) / 3)
        if before is not None:
            change = float(apart(now, before).max())
            if change <= CONVERGED:
                return ExactTip(now.times, now.u, now.v, step, change, first)
        before, coarse = now, fine
    raise ConvergenceError(
        f"exact beam at {spin.speed:g} rad/s: a step of {step:g} s still moves the tip by {change:.1e} m, "
        f"more than {CONVERGED:g} m; start from a smaller step"
    )


def _tip(problem: RotatingBeam, spin: SpinUp, step: float) -> TipMotion:
    motion = spin_up_beam(ROTATING_BEAM, spin, duration=problem.duration, step=step)
    every = round(problem.output_step / step)
    return TipMotion(motion.times[::every], motion.tip_axial[::every], motion.tip_transverse[::every])
