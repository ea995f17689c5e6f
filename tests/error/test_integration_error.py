"""What is said of the step and of the tolerance is what they cost: runs with far finer ones know."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import FullBody, NodalFixedFrame, RayleighDamping, RigidBody, RigidInterface, flexible_body
from supple.error import ErrorStudy, state_errors
from supple.error.integration_error import (
    floor_of,
    integration_errors,
    with_shorter_steps,
    with_tolerance,
)
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import AdaptiveStep, FixedStep, Newmark, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    Fixed,
    ForceBetween,
    Placed,
    PrescribedRotation,
    Prismatic,
    Revolute,
    System,
)
from supple.mesh import strip
from supple.quantities import JointForceSensor, PositionSensor, WholeBody
from supple.quantities.quantity_of_interest import quantity_distance
from supple.reduction import CompressedDerivatives, CraigBampton, NoLoads, reduce
from supple.simulation import simulate

DAMPING = RayleighDamping(alpha=0.5, beta=1e-3)


@pytest.fixture(scope="module")
def small():
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    body = flexible_body("beam", shell_model(strip(1.0, 0.1, 4, 2), wall), ends)
    return reduce(
        body,
        NodalFixedFrame("root"),
        CraigBampton(n_modes=3),
        derivatives=CompressedDerivatives(3),
        damping=DAMPING,
        loads=NoLoads,
    )


def pushed(body):
    wall = Fixed(name="wall", first=GROUND, second=At("beam", "root"))
    force = DeadForce(body="beam", at="tip", force=lambda t: 0.5 * jnp.sin(20.0 * t) * np.array([0, 0, 1.0]))
    return System((Placed(body),), (wall,), loads=(force,))


def spun(body):
    hinge = PrescribedRotation(
        name="wall", first=GROUND, second=At("beam", "root"), axis=(0, -1, 0), angle=lambda t: 0.8 * t**3
    )
    return System((Placed(body),), (hinge,))


def hanging(body):
    hinge = Revolute(name="wall", first=GROUND, second=At("beam", "root"), axis=(0, 1, 0))
    return System((Placed(body),), (hinge,), gravity=np.array([0, 0, -1.0]))


STEPS = {
    "fixed": FixedStep(0.02),
    "longer than the outputs": FixedStep(0.05),
    "adaptive": AdaptiveStep(first=1e-3, largest=0.1, tolerance=1e-4),
}
SYSTEMS = {"pushed": pushed, "spun": spun, "hanging": hanging}


def truth(system, run, solution, quantity, finer):
    """Distance from a run with a sixteenth of the step, whose own error is 1/256 of it."""
    return quantity_distance(quantity, system, solution, system, simulate(system, finer))


@pytest.mark.slow
@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("kind", STEPS)
def test_the_step_costs_what_is_said(small, name, kind):
    system = SYSTEMS[name](small)
    run = Run(0.6, 0.02, step=STEPS[kind], tolerances=Tolerances(1e-9))
    solution = simulate(system, run)
    quantity = WholeBody("beam")
    told = integration_errors(system, run, solution, [quantity])["beam"].step
    true = truth(system, run, solution, quantity, with_shorter_steps(run, 1 / 16))
    assert 0.7 < told.value / true < 1.4


@pytest.mark.slow
def test_of_another_integrator_and_other_quantities(small):
    system = pushed(small)
    run = Run(0.6, 0.02, step=FixedStep(0.01), method=Newmark(), tolerances=Tolerances(1e-9))
    solution = simulate(system, run)
    quantities = [PositionSensor("beam.tip", "beam.tip"), JointForceSensor("force of wall", "wall")]
    told = integration_errors(system, run, solution, quantities)
    for each in quantities:
        true = truth(system, run, solution, each, with_shorter_steps(run, 1 / 16))
        assert 0.7 < told[each.name].step.value / true < 1.4


def test_of_a_rigid_pendulum():
    rod = RigidBody("rod", 2.0, [0.5, 0, 0], np.diag([1e-3, 0.2, 0.2]), {"end": [0, 0, 0], "tip": [1, 0, 0]})
    hinge = Revolute(name="hinge", first=GROUND, second=At("rod", "end"), axis=(0, 1, 0))
    system = System((Placed(rod),), (hinge,), gravity=np.array([0, 0, -9.81]))
    run = Run(1.0, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-10))
    solution = simulate(system, run)
    told = integration_errors(system, run, solution, [WholeBody("rod")])["rod"]
    true = truth(system, run, solution, WholeBody("rod"), with_shorter_steps(run, 1 / 16))
    assert 0.7 < told.step.value / true < 1.4


def test_of_rigid_bodies_alone():
    """Without a quantity no further run is made; a place is measured by its own travel, x = F t^2 / 2 m."""
    block = RigidBody("block", 2.0, [0, 0, 0], np.eye(3), {"end": [0, 0, 0]})
    ends = {"first": GROUND, "second": At("block", "end"), "axis": (1, 0, 0)}
    system = System(
        (Placed(block),), (Prismatic(name="guide", **ends),), loads=(ForceBetween(force=3.0, **ends),)
    )
    run = Run(1.0, 0.1, step=FixedStep(0.1))
    solution = simulate(system, run)
    steps: list[str] = []
    assert not state_errors(system, run, solution, progress=lambda step, _: steps.append(step)).errors
    assert not steps
    study = ErrorStudy(quantities=(PositionSensor("block.end", "block.end"),))
    told = state_errors(system, run, solution, study).errors["block.end"]
    assert told.size == pytest.approx(0.75, rel=1e-9)


@pytest.mark.filterwarnings("ignore::supple.errors.ResolutionWarning")  # it is what this is about
@pytest.mark.parametrize(
    ("jump", "highest"),
    [pytest.param(0.1, 1.1, id="at a step"), pytest.param(0.105, 2.1, id="between", marks=pytest.mark.slow)],
)
def test_of_a_force_that_jumps(jump, highest):
    """A slider of 2 kg is pushed by 3 N from an instant on: x = F (t - t0)^2 / 2 m, against the exact motion.

    The error falls by 2, not by 4. A quarter into its step the jump is seen too early by a quarter of it,
    and right by half the step: the half of what is stated is there.
    """
    block = RigidBody("block", 2.0, [0, 0, 0], np.eye(3), {"end": [0, 0, 0]})
    guide = Prismatic(name="guide", first=GROUND, second=At("block", "end"), axis=(1, 0, 0))
    push = ForceBetween(
        first=GROUND,
        second=At("block", "end"),
        axis=(1, 0, 0),
        force=lambda t: jnp.where(t < jump - 1e-9, 0.0, 3.0),
    )
    system = System((Placed(block),), (guide,), (push,))
    run = Run(0.4, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-10))
    solution = simulate(system, run, check=False)
    exact = 3.0 / 2.0 * np.maximum(solution.times - jump, 0.0) ** 2 / 2.0
    true = np.abs(solution.bodies["block"].position[:, 0] - exact).max()
    told = integration_errors(system, run, solution, [WholeBody("block")])["block"].step
    assert 0.95 < told.value / true < highest


@pytest.mark.slow
@pytest.mark.parametrize("name", SYSTEMS)
def test_newtons_tolerance_costs_what_is_said_or_less_than_the_floor(small, name):
    """A loose tolerance leaves an error above the floor in some systems, below it in others."""
    system = SYSTEMS[name](small)
    run = Run(0.6, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-2))
    solution = simulate(system, run)
    quantity = WholeBody("beam")
    told = integration_errors(system, run, solution, [quantity])["beam"].newton
    tight = simulate(system, with_tolerance(run, 1e-11))
    true = quantity_distance(quantity, system, solution, system, tight)
    floor = floor_of(run.tolerances, quantity.size(system, solution))
    assert told.value >= floor
    assert 0.7 < told.value / max(true, floor) < 1.4


@pytest.mark.slow
def test_without_runs_the_floor_is_all_that_is_stated(small):
    system = pushed(small)
    run = Run(0.1, 0.02, step=FixedStep(0.02))
    solution = simulate(system, run)
    told = integration_errors(system, run, solution, [WholeBody("beam")], measured=False)["beam"]
    assert told.step is None
    assert told.newton.value == pytest.approx(10 * 1e-6 * WholeBody("beam").size(system, solution))


@pytest.mark.slow
def test_a_run_that_breaks_off_has_no_known_error(small):
    system = pushed(small)
    run = Run(0.1, 0.02, step=FixedStep(0.02))
    stopped = replace(simulate(system, run), stopped="no convergence")
    told = integration_errors(system, run, stopped, [WholeBody("beam")])["beam"]
    assert told.newton.value == np.inf


@pytest.mark.slow
def test_full_bodies_are_told_of_as_well(small):
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    body = flexible_body("beam", shell_model(strip(1.0, 0.1, 2, 2), wall), ends)
    system = pushed(FullBody(body, NodalFixedFrame("root"), DAMPING))
    run = Run(0.2, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-9))
    solution = simulate(system, run)
    quantity = WholeBody("beam")
    told = integration_errors(system, run, solution, [quantity])["beam"].step
    true = truth(system, run, solution, quantity, with_shorter_steps(run, 1 / 8))
    assert 0.7 < told.value / true < 1.4
