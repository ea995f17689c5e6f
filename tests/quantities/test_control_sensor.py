"""Outputs of controllers beside the solution of a linear equation, in machines of every engine."""

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.bar_of_every_form import bar_as

from supple.body import RigidBody
from supple.errors import ModelError
from supple.integrate import FixedStep, Run
from supple.machine import (
    GROUND,
    Controller,
    JointReading,
    Placed,
    Revolute,
    SampledController,
    System,
    TorqueBetween,
)
from supple.quantities import ControlSensor, ElementEnergySensor, QuantityKind, SpringForceSensor
from supple.simulation import simulate, simulate_batch, simulate_recorded
from supple.storage import read_solution

RUN = Run(1.0, 0.1, FixedStep(0.01))
MOTOR = TorqueBetween(first=GROUND, second="rotor.hub", axis=(0, 0, 1), torque=3.0)


def rotor(controller, others=()):
    """A rotor of inertia 2 on a hinge, and a free body beside it that nothing moves."""
    own = RigidBody("rotor", 1.0, np.zeros(3), 2 * np.eye(3), {"hub": np.zeros(3)})
    hinge = Revolute(first=GROUND, second="rotor.hub", axis=(0, 0, 1), name="hinge")
    beside = [Placed(each, position=(0.0, 5.0, 0.0)) for each in others]
    return System([own, *beside], [hinge], controllers=[controller])


LOOP = Controller(
    reads={"hinge": JointReading("hinge")},
    drives={"motor": MOTOR},
    outputs=lambda _, reads, states: {"motor": 2.0 - 0.5 * reads["hinge"].rate + states[0]},
    rates=lambda *_: jnp.ones(1),
    initial=[0.0],
    name="loop",
)


def check(system, solution):
    """2 w' = 3 + u, u = 2 - w/2 + t: u = 1 + exp(-t/4), w = 2 t + 2 - 2 exp(-t/4)."""
    t = solution.times
    u, w = 1 + np.exp(-t / 4), 2 * t + 2 - 2 * np.exp(-t / 4)
    sensor = ControlSensor("u", "loop")
    assert [each[:2] for each in sensor.channels(system)] == [("motor", QuantityKind.NUMBER)]
    np.testing.assert_allclose(sensor.values(system, solution)[:, 0], u, rtol=1e-5)
    np.testing.assert_allclose(SpringForceSensor("m", MOTOR).values(system, solution)[:, 5], 3 + u, rtol=1e-5)
    power = ElementEnergySensor("p", MOTOR).values(system, solution)[:, 1]
    np.testing.assert_allclose(power, (3 + u) * w, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("form", [None, "full", pytest.param("intrinsic", marks=pytest.mark.slow)])
def test_outputs_and_the_torque_that_they_drive_are_known(form):
    system = rotor(LOOP, [] if form is None else [bar_as(form)])
    check(system, simulate(system, RUN))


def test_result_files_and_batches_contain_outputs(tmp_path):
    system = rotor(LOOP)
    simulate_recorded(system, RUN, tmp_path / "run.h5", case="")
    check(system, read_solution(tmp_path / "run.h5"))
    for found in simulate_batch([system, system], RUN).solutions:
        check(system, found)


def test_the_output_at_a_sample_time_is_that_before_the_call():
    sampled = SampledController(
        reads={},
        drives={"motor": MOTOR},
        law=lambda time, *_: ({"motor": 2 * time}, {}),
        every=0.2,
        name="loop",
    )
    system = rotor(sampled)
    found = ControlSensor("u", "loop").values(system, simulate(system, RUN))[:, 0]
    np.testing.assert_allclose(found, [0, 0, 0, 0.4, 0.4, 0.8, 0.8, 1.2, 1.2, 1.6, 1.6], atol=1e-12)


def test_an_unknown_controller_is_refused():
    system = rotor(LOOP)
    with pytest.raises(ModelError, match=r"no controller 'lop'; did you mean 'loop'\?"):
        ControlSensor("u", "lop").channels(system)
