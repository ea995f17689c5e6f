"""Estimated errors of small reduced runs, compared with their true errors.

The true basis error is the difference from a run of all coordinates with equal steps, by another engine
(sparse Newton iteration of the whole system). The true step error follows from a closed form.
"""

from __future__ import annotations

import warnings

import jax.numpy as jnp
import numpy as np

from supple.body import FullBody, NodalFixedFrame, RayleighDamping, RigidBody, RigidInterface, flexible_body
from supple.error import ErrorStudy, ReductionStart, SelfCorrection, self_correct, state_errors
from supple.errors import SuppleWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import ErrorPart, FixedStep, FloatingMotion, Run, Tolerances
from supple.machine import GROUND, At, DeadForce, Fixed, ForceBetween, Placed, Prismatic, Ramp, System
from supple.mesh import strip
from supple.quantities import JointForceSensor, PositionSensor, QuantityOfInterest, StressSensor, WholeBody
from supple.quantities.quantity_of_interest import quantity_distance
from supple.reduction import CompressedDerivatives, CraigBampton
from supple.simulation import simulate
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES"]

BAND = 0.4
"""Allowed |estimated - true error| over the true error: the order of magnitude must be right."""
FULL_RUN = "run of all coordinates with the same steps"

_MODEL = shell_model(strip(1.0, 0.1, 4, 2), HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01))
_WHOLE = WholeBody("strip")


def _strip(damping: RayleighDamping) -> FullBody:
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    return FullBody(flexible_body("strip", _MODEL, ends), NodalFixedFrame("root"), damping)


def _pushed(body: FullBody, force: tuple[float, float, float], rise: float) -> System:
    wall = Fixed(name="wall", first=GROUND, second=At("strip", "root"))
    push = DeadForce(body="strip", at="tip", force=Ramp(np.array(force), rise))
    return System((Placed(body),), (wall,), loads=(push,))


def _corrected(
    system: System, run: Run, start: ReductionStart, quantities: tuple[QuantityOfInterest, ...]
) -> list[Comparison]:
    """Estimated basis errors of the accepted run, compared with its differences from the full run.

    Without an estimate the value is NaN, so the row does not hold.
    """
    study = ErrorStudy(integration=False, model=False, quantities=quantities)
    corrected = self_correct(system, run, start, study=study)
    reference = simulate(system, run)
    return [
        Comparison(
            f"estimated error, {each.name}",
            _value(corrected.solution.errors[each.name].basis),
            quantity_distance(each, corrected.system, corrected.solution, system, reference),
            FULL_RUN,
            BAND,
        )
        for each in (_WHOLE, *quantities)
    ]


def _value(estimate: ErrorPart | None) -> float:
    return float("nan") if estimate is None else estimate.value


def _bent_far() -> list[Comparison]:
    """A strip bent to 0.3 rad by a tip force: errors of the whole body, tip, middle stress, clamp force."""
    middle = np.flatnonzero(_MODEL.mesh.nodes[:, 0] == 0.5)
    quantities = (
        PositionSensor("strip.tip", "strip.tip"),
        StressSensor("stress at middle", "strip", _MODEL, middle),
        JointForceSensor("force of wall", "wall"),
    )
    run = Run(0.4, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-9))
    start = ReductionStart(SelfCorrection(relative=0.05), CraigBampton(1), CompressedDerivatives(2))
    return _corrected(
        _pushed(_strip(RayleighDamping(0.5, 1e-3)), (0.0, 0.0, 3.0), 0.3), run, start, quantities
    )


def _tips_sideways() -> list[Comparison]:
    """Lateral buckling of a strip: error of the accepted run.

    The basis of the first run locks, and its estimated error is 3 % of its true error.
    """
    run = Run(1.2, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-9))
    system = _pushed(_strip(RayleighDamping(2.0, 1e-3)), (0.0, 50.0, 0.05), 1.0)
    return _corrected(system, run, ReductionStart(SelfCorrection(relative=0.06)), ())


def _jumps() -> list[Comparison]:
    """A slider of m = 2 kg with a force F = 3 N from t = 0.1 s on: x = F (t - 0.1)^2 / (2 m)."""
    block = RigidBody("block", 2.0, np.zeros(3), np.eye(3), {"end": np.zeros(3)})
    guide = Prismatic(name="guide", first=GROUND, second=At("block", "end"), axis=(1, 0, 0))
    push = ForceBetween(
        first=GROUND,
        second=At("block", "end"),
        axis=(1, 0, 0),
        force=lambda t: jnp.where(t < 0.1 - 1e-9, 0.0, 3.0),
    )
    system = System((Placed(block),), (guide,), (push,))
    run = Run(0.4, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-10))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SuppleWarning)  # the warning of the intended jump of the force
        solution = simulate(system, run)
        study = ErrorStudy(quantities=(WholeBody("block"),))
        stated = state_errors(system, run, solution, study).errors["block"]
    exact = 3.0 / 2.0 * np.maximum(solution.times - 0.1, 0.0) ** 2 / 2.0
    true = float(np.abs(solution.motion("block", FloatingMotion).position[:, 0] - exact).max())
    return [Comparison("estimated error of the step, m", _value(stated.step), true, "closed form", 0.1)]


CASES: tuple[ValidationCase, ...] = (
    ValidationCase("error estimate, strip in large bending", _bent_far),
    ValidationCase("error estimate, lateral buckling of a strip", _tips_sideways, quick=False),
    ValidationCase("error estimate, a sudden force", _jumps),
)
