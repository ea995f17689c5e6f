"""Parameters of an FMU: changing one is running the machine with that number changed."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from fixtures.compiled_c import needs_compiler
from fixtures.exported_machines import STEP, linked, run

from supple.errors import ModelError
from supple.export.fmu.write_fmu import write_fmu
from supple.machine import Placed, SpringDamper, System, TorqueBetween
from supple.quantities import JointMotionSensor, PositionSensor, SpringForceSensor
from supple.stepping import step_program
from supple.stepping.parameters import MachineParameters
from supple.stepping.variables import Variable

CASE = {"stiffness": 30.0, "fall": -9.81, "mass": 2.0, "speed": 0.5, "torque": 0.1}
OTHER = {"stiffness": 80.0, "fall": -3.0, "mass": 5.0, "speed": -2.0, "torque": 0.1}


def made(stiffness, fall, mass, speed, torque):
    """Two rods that start to turn about the first hinge, with a spring at the end and a motor."""
    bodies, joints = linked(2)
    heavier = replace(bodies[1].body, mass=mass)
    bodies = [
        replace(bodies[0], angular_velocity=(0.0, 0.0, speed)),
        Placed(
            heavier,
            position=bodies[1].position,
            velocity=(0.0, 0.4 * speed, 0.0),
            angular_velocity=(0.0, 0.0, speed),
        ),
    ]
    motor = TorqueBetween(first="l0.b", second="l1.a", torque=torque, axis=(0, 0, 1))
    spring = SpringDamper(
        first="ground",
        second="l1.b",
        anchor=(0.5, 0.5, 0.0),
        stiffness=stiffness,
        damping=0.5,
        rest_length=0.3,
    )
    sensors = [
        PositionSensor("tip", "l1.b"),
        SpringForceSensor("spring", spring),
        JointMotionSensor("j", "j1"),
    ]
    return (
        System(bodies, joints, loads=[motor, spring], gravity=np.array([0, fall, 0])),
        sensors,
        {"motor": motor},
    )


def parametric(*names):
    """The machine with parameters of these names."""
    system, sensors, inputs = made(**CASE)
    variables = tuple(Variable(name, "", name, CASE[name]) for name in names)
    parameters = MachineParameters(
        variables, lambda values: made(**CASE | dict(zip(names, values, strict=True)))
    )
    return step_program(system, run(), sensors, inputs, parameters=parameters)


@pytest.fixture(scope="module")
def step():
    return parametric("stiffness", "fall", "mass", "speed")


@pytest.fixture(scope="module")
def expected():
    """Outputs of 50 steps of the machine made with the other numbers."""
    system, sensors, inputs = made(**OTHER)
    other = step_program(system, run(), sensors, inputs)
    now, rows = other.start, [other.start.output]
    for k in range(1, 51):
        now = other.compiled(now, k * STEP)
        rows.append(np.asarray(now.output))
    return np.array(rows)


VALUES = np.array([OTHER[name] for name in ("stiffness", "fall", "mass", "speed")])


@pytest.mark.slow
def test_a_machine_with_other_parameters_is_the_machine_made_with_them(step, expected):
    now, rows = step.started(VALUES, step.start.input), []
    now = jax.tree.map(np.asarray, now)
    for k in range(51):
        now = step.compiled(now, k * STEP) if k else now
        rows.append(np.asarray(now.output))
    np.testing.assert_allclose(rows, expected, atol=1e-8)


@pytest.mark.slow
def test_the_start_of_the_case_is_that_of_its_values(step):
    again = step.started(step.start.parameter, step.start.input)
    np.testing.assert_allclose(again.state.acceleration, step.start.state.acceleration, atol=1e-10)
    np.testing.assert_allclose(again.output, step.start.output, atol=1e-12)


@pytest.mark.slow
def test_what_the_start_depends_on_is_fixed(step):
    assert step.fixed_parameters == {3}


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("fmi", [3, 2])
def test_an_fmu_with_other_parameters_gives_the_motion_of_the_other_machine(
    step, expected, fmi, tmp_path, monkeypatch
):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    monkeypatch.setenv("CFLAGS", "-O0")
    path = write_fmu(tmp_path / "machine.fmu", step, "machine", fmi=fmi)
    assert validate_fmu(str(path)) == []
    names = [each.name for each in step.outputs.variables]
    found = fmpy.simulate_fmu(
        str(path),
        stop_time=50 * STEP,
        step_size=STEP,
        output_interval=STEP,
        output=names,
        start_values=dict(zip(("stiffness", "fall", "mass", "speed"), VALUES, strict=True)),
    )
    rows = np.array([[row[name] for name in names] for row in found])
    np.testing.assert_allclose(rows, expected, atol=1e-8)


@pytest.mark.parametrize(
    ("name", "message"), [("torque", "changes nothing"), ("length", "not depend linearly")]
)
def test_a_parameter_that_cannot_be_one_is_refused(name, message):
    system, sensors, inputs = made(**CASE)
    start = {"torque": 0.1, "length": 0.0}[name]

    def variant(values):
        if name == "torque":
            return made(**CASE | {"torque": float(values[0])})
        moved, own, motor = made(**CASE)
        # A place along a circle.
        turn = np.array(
            [[np.cos(values[0]), -np.sin(values[0]), 0], [np.sin(values[0]), np.cos(values[0]), 0], [0, 0, 1]]
        )
        bodies = [
            replace(each, position=turn @ np.asarray(each.position), rotation=turn) for each in moved.bodies
        ]
        return replace(moved, bodies=tuple(bodies)), own, motor

    parameters = MachineParameters((Variable(name, "", name, start),), variant)
    with pytest.raises(ModelError, match=message):
        step_program(system, run(), sensors, inputs, parameters=parameters)
