"""Controllers and friction of joints in machines with intrinsic bodies: beside the same reduced bodies."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import RigidBody
from supple.errors import ConvergenceError, ModelError
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Solution, Statistics
from supple.machine import (
    At,
    Controller,
    EndReading,
    Fixed,
    HingeFriction,
    JointReading,
    Placed,
    Revolute,
    SampledController,
    System,
    TorqueBetween,
)
from supple.methods.intrinsic import CLAMPED, enough_modes, intrinsic_body, released, truncation_error
from supple.methods.intrinsic.truncation_error import report_truncation
from supple.simulation import equilibrium, simulate

HINGE = Revolute(first="ground", second="beam.root", axis=(0, 1, 0), name="hinge")
MOTOR = TorqueBetween(first="ground", second="beam.root", axis=(0, 1, 0), torque=0.0)
STIFF = {"EA": 1e5, "EI": 1e3, "GJ": 1e3, "mass_per_length": 1.0, "radius": 0.05}
READS = {"hinge": JointReading("hinge"), "tip": EndReading("beam.tip")}
RUN = Run(1.0, 0.25, step=FixedStep(5e-3), method=GeneralizedAlpha(0.9))


def rod():
    """A stiff beam, and a rigid body of its mass and inertia."""
    body = released(intrinsic_body(beam_line(straight(1.0, 4), **STIFF), CLAMPED))
    twists = body.line.twists
    gram = twists.T @ body.line.mass @ twists
    centre = np.array([0.5, 0, 0])
    inertia = gram[3:, 3:] - np.diag([0, 0.25, 0.25])
    ends = {"root": -centre, "tip": centre}
    return body, Placed(RigidBody("beam", 1.0, np.zeros(3), inertia, ends), position=centre)


def angles(solution):
    rotation = solution.bodies["beam"].rotation
    return np.arctan2(rotation[:, 0, 2], rotation[:, 0, 0])


def servo(_, readings, states):
    """Up to an angle, with an integral of what the tip lacks."""
    hinge = readings["hinge"]
    return {"motor": 4.0 * (0.3 - hinge.angle) - 1.0 * hinge.rate + 2.0 * states[0]}


@pytest.mark.slow
def test_a_traced_controller_turns_a_beam_as_it_turns_a_rod():
    def lag(_, readings, states):
        return jnp.stack([-jnp.sin(0.3) - readings["tip"].point[2] - 0.0 * states[0]]) * -1.0

    own = Controller(
        reads=READS, drives={"motor": MOTOR}, outputs=servo, rates=lag, initial=[0.0], name="servo"
    )
    found = [angles(simulate(System([body], [HINGE], controllers=[own]), RUN)) for body in rod()]
    assert np.abs(found[1]).max() > 0.2
    assert found[0] == pytest.approx(found[1], abs=2e-3)


@pytest.mark.slow
def test_a_sampled_controller_is_called_in_time():
    called = []

    def law(time, readings, memory):
        called.append(time)
        # No rate: sampled, that of the root would stir vibrations that a rod has not.
        missing = 0.3 - readings["hinge"].angle
        total = memory["total"] + 0.01 * missing
        return {"motor": 2.0 * missing + total}, {"total": total}

    own = SampledController(
        reads=READS, drives={"motor": MOTOR}, law=law, every=0.01, memory={"total": 0.0}, name="servo"
    )
    found = [angles(simulate(System([body], [HINGE], controllers=[own]), RUN)) for body in rod()]
    assert np.abs(found[1]).max() > 0.2
    assert found[0] == pytest.approx(found[1], rel=1e-2)
    machine = System([rod()[0]], [HINGE], controllers=[own])
    called.clear()
    assert angles(simulate(machine, RUN)) == pytest.approx(found[0], abs=1e-12)
    assert called == pytest.approx(0.01 * np.arange(100))


@pytest.mark.slow
def test_friction_of_a_hinge_follows_the_force_that_it_carries():
    """Beside a rigid rod; a joint that carries nothing has none."""
    friction = HingeFriction(joint=HINGE, coefficient=0.4, radius=0.3, width=0.05)
    found = []
    for body in rod():
        free, held = (
            simulate(System([body], [HINGE], loads, gravity=[0, 0, -9.81]), RUN) for loads in ([], [friction])
        )
        found.append(angles(held))
        assert angles(held)[2] < 0.9 * angles(free)[2]
    assert found[0] == pytest.approx(found[1], abs=5e-3)


def test_friction_that_jams_at_the_start_is_an_error():
    """The moment mu R N of a pin changes N by 3 mu R / (2 L) of itself: more than one."""
    beam, pinned = rod()
    pinned = replace(
        pinned, body=replace(pinned.body, name="rod"), angular_velocity=np.array([0.0, 1.0, 0.0])
    )
    hinge = replace(HINGE, second=At("rod", "root"))
    friction = HingeFriction(joint=hinge, coefficient=5.0, radius=0.3, width=0.05)
    with pytest.raises(ConvergenceError, match="friction and the forces in the joints do not converge"):
        simulate(System([beam, pinned], [hinge], [friction]), RUN)


def test_controllers_ask_for_released_bodies():
    clamped = intrinsic_body(beam_line(straight(1.0, 4), **STIFF), CLAMPED)
    clamp = Fixed(first="ground", second="beam.root", name="clamp")
    own = Controller(
        reads={"tip": EndReading("beam.tip")},
        drives={"motor": MOTOR},
        outputs=lambda *_: {"motor": jnp.zeros(())},
    )
    machine = System([clamped], [clamp], controllers=[own])
    with pytest.raises(ModelError, match=r"its modes belong to a supported root.*place released\(body\)"):
        simulate(machine, RUN)
    with pytest.raises(ModelError, match=r"its modes belong to a supported root.*place released\(body\)"):
        equilibrium(machine)


def test_a_controlled_run_with_few_modes_has_no_truncation_error():
    """Forces of controllers during the run are unknown; the run itself is complete."""
    few = released(intrinsic_body(beam_line(straight(1.0, 4), **STIFF), CLAMPED, 2))
    own = SampledController(
        reads={}, drives={"motor": MOTOR}, law=lambda *_: ({"motor": 0.1}, {}), every=0.05, name="servo"
    )
    machine = System([few], [HINGE], controllers=[own])
    solution = Solution(np.zeros(1), {}, {}, Statistics(), multipliers={"hinge": np.zeros((1, 5))})
    assert not report_truncation(machine, RUN, solution).truncation
    with pytest.raises(ModelError, match=r"controller 'servo'.*the forces of controllers is not computed"):
        truncation_error(machine, solution)
    with pytest.raises(ModelError, match="the forces of controllers is not computed"):
        enough_modes(machine, lambda _: solution, tolerance=1e-2)


@pytest.mark.slow
def test_a_sampled_run_in_two_parts_is_one_run():
    called = []

    def law(time, readings, memory):
        called.append(time)
        total = memory["total"] + readings["hinge"].angle
        return {"motor": 0.3 - total}, {"total": total}

    own = SampledController(
        reads=READS, drives={"motor": MOTOR}, law=law, every=0.03, memory={"total": 0.0}, name="servo"
    )
    machine = System([rod()[0]], [HINGE], controllers=[own])
    run = Run(0.2, 0.05, step=FixedStep(5e-3), method=GeneralizedAlpha(0.9))
    parts = []
    whole = simulate(machine, run, record=parts.append)
    assert len(parts) > 2
    called.clear()
    rest = simulate(machine, run, resume=parts[1])
    assert np.array_equal(rest.bodies["beam"].rates[-1], whole.bodies["beam"].rates[-1])
    assert called == pytest.approx([time for time in 0.03 * np.arange(7) if time >= parts[1].times[-1]])
