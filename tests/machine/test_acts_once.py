"""What would act twice, or not at all, is refused when the machine is built."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple import machine as m
from supple.body import RigidBody
from supple.errors import ModelError
from supple.machine import System

ENDS = {"first": "ground", "second": "wheel.axle"}
HINGE = m.Revolute(**ENDS, axis=(0, 0, 1), name="hinge")
SLIDE = m.Prismatic(**ENDS, axis=(1, 0, 0), name="slide")
TORQUE = m.TorqueBetween(**ENDS, axis=(0, 0, 1), torque=0.1)


def wheel(*, joint=HINGE, loads=(), controllers=()):
    body = RigidBody("wheel", 1.0, np.zeros(3), np.eye(3), {"axle": np.zeros(3)})
    return System([body], [joint], loads, controllers=controllers)


def driving(element, name="clock"):
    return m.Controller(reads={}, drives={"motor": element}, outputs=lambda *_: {"motor": 0.0}, name=name)


def test_an_element_that_is_driven_does_not_stand_among_the_loads():
    words = r"controller 'clock' drives TorqueBetween on ground \('motor'\), which is also among the loads"
    with pytest.raises(ModelError, match=words + ".*act twice; leave it out of loads"):
        wheel(loads=[TORQUE], controllers=[driving(TORQUE)])
    sampled = m.SampledController(
        reads={}, drives={"motor": TORQUE}, law=lambda *_: ({"motor": 0.0}, {}), every=0.1, name="clock"
    )
    with pytest.raises(ModelError, match=words):
        wheel(loads=[TORQUE], controllers=[sampled])
    # Another element of the same kind is another motor.
    wheel(loads=[replace(TORQUE)], controllers=[driving(TORQUE)])


def test_an_element_is_driven_by_one_output():
    words = "controller 'b' drives TorqueBetween on ground, which another output drives already"
    with pytest.raises(ModelError, match=words + ".*a separate element"):
        wheel(controllers=[driving(TORQUE, "a"), driving(TORQUE, "b")])
    wheel(controllers=[driving(TORQUE, "a"), driving(replace(TORQUE), "b")])


def test_a_servo_moves_what_its_joint_leaves_free():
    def angle(axis):
        return m.AngleServo(**ENDS, axis=axis, angle=0.1, stiffness=2.0)

    def along(axis):
        return m.SlideServo(**ENDS, axis=axis, slide=0.1, stiffness=2.0)

    words = r"AngleServo on ground: it has no effect, because joint 'hinge' fixes its ends along the axis "
    with pytest.raises(
        ModelError, match=words + r"\(1, 0, 0\): give it an axis along \[0.0, 0.0, 1.0\], which the joint "
    ):
        wheel(loads=[angle((1, 0, 0))])
    with pytest.raises(
        ModelError, match=r"SlideServo on ground: it has no effect, .* give it ends that can move"
    ):
        wheel(loads=[along((0, 0, 1))])
    with pytest.raises(ModelError, match="joint 'slide' fixes its ends"):
        wheel(joint=SLIDE, loads=[along((0, 1, 0))])
    with pytest.raises(ModelError, match="joint 'slide' fixes its ends"):
        wheel(joint=SLIDE, controllers=[driving(angle((1, 0, 0)))])
    curve, swapped = m.Curve((0.0, 1.0), (1.0, 0.0)), {"first": "wheel.axle", "second": "ground"}
    motor = m.MotorCurve(**swapped, axis=(0, 1, 0), torque=curve)
    with pytest.raises(ModelError, match="joint 'hinge' fixes its ends"):
        wheel(loads=[motor])
    for system in (
        wheel(loads=[angle((0, 0, -1))]),
        wheel(joint=SLIDE, loads=[along((1, 0, 0))]),
        wheel(joint=m.Ball(**ENDS), loads=[angle((1, 1, 0))]),
        wheel(
            joint=m.Universal(**ENDS, first_axis=(0, 0, 1), second_axis=(1, 0, 0)), loads=[angle((1, 0, 0))]
        ),
        wheel(joint=m.PrescribedRotation(**ENDS, axis=(0, 0, 1), angle=0.0), loads=[angle((0, 0, 1))]),
    ):
        assert system.n_constraints
