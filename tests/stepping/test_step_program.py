"""Step programs: derivatives against differences, states that are set, machines that have none."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.bar_of_every_form import bar_as
from fixtures.beam_lines import beam_line, straight
from fixtures.exported_machines import STEP, blade, driven_pair, link, linked, run, servo_arm

import supple as sp
from supple.body import RigidBody
from supple.equations.compiler_options import STARTING
from supple.errors import ModelError
from supple.integrate import FixedStep, GeneralizedAlpha, Kinematic, Run
from supple.machine import (
    Fixed,
    Placed,
    PrescribedRotation,
    Revolute,
    SampledController,
    System,
    TorqueBetween,
)
from supple.machine.system import AssembledPose
from supple.methods.intrinsic import CLAMPED, intrinsic_body, released
from supple.quantities import (
    DeflectionSensor,
    ElementEnergySensor,
    JointMotionSensor,
    PositionSensor,
    SpringForceSensor,
)
from supple.stepping.external_inputs import external_inputs

BEFORE = 5
"""Steps before the one that is differentiated"""


def check_derivatives(program, changed, width):
    """Of the outputs of a step, against central differences; `changed` gives the instant by a number x."""
    now = program.start
    for k in range(1, BEFORE + 1):
        now = program.compiled(now, STEP * k)
    now, end, x = jax.device_get(now), STEP * (BEFORE + 1), np.float64(0.1)

    def derivative(x):
        return jax.jvp(lambda own: program.advanced(changed(now, own), end).output, (x,), (jnp.ones(()),))[1]

    exact = jax.jit(derivative).lower(x).compile(STARTING)(x)
    ahead, back = (program.compiled(changed(now, x + own), end).output for own in (width, -width))
    by_difference = (ahead - back) / (2 * width)
    size = np.abs(by_difference).max()
    assert size > 0
    np.testing.assert_allclose(exact / size, by_difference / size, atol=1e-6)


@pytest.mark.slow
def test_derivatives_for_an_input_are_those_of_the_discrete_motion():
    system, its_run, sensors, inputs = driven_pair()
    program = sp.step_program(system, its_run, sensors, inputs)
    check_derivatives(program, lambda now, x: now._replace(input=jnp.stack([x])), 1e-2)


@pytest.mark.slow
def test_derivatives_for_the_state_do_not_depend_on_a_frozen_tangent():
    """Through the iteration itself they would be as inexact as its tangent."""
    system, its_run, sensors, _ = blade()
    program = sp.step_program(system, its_run, sensors[:2])
    assert program.start.state.kept is not None

    def faster(now, x):
        velocity = jnp.asarray(now.state.velocity).at[-1].add(0.1 * x)
        return now._replace(state=now.state._replace(velocity=velocity))

    check_derivatives(program, faster, 1e-2)


@pytest.mark.slow
def test_two_steps_are_one_call_to_their_end():
    system, its_run, sensors, inputs = driven_pair()
    program = sp.step_program(system, its_run, sensors, inputs)
    one = program.compiled(program.compiled(program.start, STEP), 2 * STEP)
    both = program.compiled(program.start, 2 * STEP)
    np.testing.assert_allclose(one.output, both.output, rtol=1e-12, atol=1e-14)
    again = program.compiled(both, 2 * STEP)  # no time passes
    np.testing.assert_array_equal(again.output, both.output)


def test_an_input_that_no_equation_reads_is_refused():
    system, its_run, _, inputs = driven_pair()
    external = external_inputs(system, inputs, {}, its_run.start)
    with pytest.raises(ModelError, match="'motor' cannot be an input"):
        external.check_read(np.zeros(3))


def test_the_moment_of_a_servo_follows_its_input():
    system, its_run, sensors, inputs = servo_arm()
    servo = inputs["target"]
    sensors = [*sensors, SpringForceSensor("moment", servo), ElementEnergySensor("work", servo)]
    program = sp.step_program(system, its_run, sensors, inputs)
    after = program.compiled(program.start._replace(input=np.array([0.01])), STEP)
    named = {
        each.name: float(value) for each, value in zip(program.outputs.variables, after.output, strict=True)
    }
    moment = 400.0 * (0.01 - named["shoulder.angle"]) - 20.0 * named["shoulder.rate"]
    assert named["moment.Mz"] == pytest.approx(moment, rel=1e-10)
    assert named["work.power"] == pytest.approx(moment * named["shoulder.rate"], rel=1e-10)


def wheel_with_motor(step):
    inertia = 0.5
    wheel = RigidBody("wheel", 1.0, np.zeros(3), inertia * np.eye(3), {"hub": np.zeros(3)})
    hinge = Revolute(first="ground", second="wheel.hub", axis=(0, 0, 1), name="hinge")
    motor = TorqueBetween(first="ground", second="wheel.hub", axis=(0, 0, 1))
    system = System([wheel], [hinge], loads=[motor])
    its_run = Run(1.0, 0.01, step=FixedStep(step))
    return sp.step_program(system, its_run, [JointMotionSensor("hinge", "hinge")], {"motor": motor}), inertia


@pytest.mark.parametrize("step", [0.01, 0.005])
def test_a_digital_controller_outside_acts_without_delay(step):
    """The torque is constant between two samples, and the motion of the wheel a parabola."""
    program, inertia = wheel_with_motor(step)
    now, angle, rate, h = program.start, 0.0, 0.0, 0.01
    for sample in range(1, 21):
        given = 80.0 * (0.5 - np.asarray(now.output)[0]) - 6.0 * np.asarray(now.output)[1]
        now = program.compiled(now._replace(input=np.array([given])), h * sample)
        torque = 80.0 * (0.5 - angle) - 6.0 * rate
        angle, rate = angle + h * rate + h**2 * torque / inertia / 2, rate + h * torque / inertia
        np.testing.assert_allclose(np.asarray(now.output)[:2], [angle, rate], rtol=1e-12)


@pytest.mark.parametrize("given", [0.0, 1.3])
def test_the_derivative_for_an_input_is_that_of_its_jump(given):
    program, inertia = wheel_with_motor(0.01)  # 0 is the input of the start, which does not jump

    def ahead(x):
        return program.advanced(program.start._replace(input=x[None]), 0.01).output[:2]

    found = jax.jit(jax.jacfwd(ahead)).lower(np.float64(given)).compile(STARTING)(np.float64(given))
    np.testing.assert_allclose(found, [0.01**2 / inertia / 2, 0.01 / inertia], rtol=1e-12)


def held_line():
    """A line whose modes hold its root."""
    section = {"EA": 1e4, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.05}
    return intrinsic_body(beam_line(straight(1.0, 2), name="line", **section), CLAMPED)


def turned(body, end="root"):
    """A body on a prescribed hinge, its run, a sensor at its tip."""
    shaft = PrescribedRotation(
        first="ground", second=f"{body.name}.{end}", axis=(0, 0, 1), angle=lambda time: time**2, name="shaft"
    )
    return System([Placed(body)], [shaft]), run(), [PositionSensor("tip", f"{body.name}.tip")]


def test_machines_without_a_step_program_are_refused_with_the_remedy():
    with pytest.raises(ModelError, match="'bar': full bodies are stepped by sparse factors"):
        sp.step_program(*turned(bar_as("full")))
    system = System([Placed(bar_as("modal"))], [Fixed(first="ground", second="bar.root")])
    with pytest.raises(ModelError, match="'bar': modal subdomains"):
        sp.step_program(system, run(), [PositionSensor("tip", "bar.tip")])
    with pytest.raises(ModelError, match="supported root have no step program: place released"):
        sp.step_program(*turned(held_line()))
    system, its_run, sensors = turned(released(held_line()))
    its_run = replace(its_run, method=GeneralizedAlpha(0.9))
    with pytest.raises(ModelError, match="'shaft' cannot be an input beside intrinsic bodies"):
        sp.step_program(system, its_run, sensors, {"shaft": system.joints[0]})
    bodies, joints = linked(1)
    sensors = [JointMotionSensor("hinge", "j0")]
    with pytest.raises(ModelError, match="a run by Kinematic has no step program"):
        sp.step_program(System(bodies, joints), replace(run(), method=Kinematic()), sensors)
    motor = TorqueBetween(first="ground", second="l0.a", torque=0.0, axis=(0, 0, 1))
    sampled = SampledController(
        reads={}, drives={"motor": motor}, law=lambda *_: ({"motor": 0.0}, {}), every=0.1
    )
    with pytest.raises(ModelError, match="a sampled controller runs Python"):
        sp.step_program(System(bodies, joints, controllers=[sampled]), run(), sensors)


def test_a_deflection_seen_from_another_body_is_in_the_mesh_axes_of_its_place():
    """The second rod is along y and has moved by (0.1, 0.2, 0.3) since assembly: mesh axes x = Y, y = -X."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assembled = AssembledPose(np.array([0.4, 0.0, 0.0]), turn)
    moved = Placed(link(1), position=[0.5, 0.2, 0.3], rotation=turn, assembled=assembled)
    sensor = DeflectionSensor("apart", "l1.b", "l0.b")
    program = sp.step_program(System([Placed(link(0)), moved]), run(), [sensor])
    np.testing.assert_allclose(program.start.output, [0.2, -0.1, 0.3], atol=1e-14)
