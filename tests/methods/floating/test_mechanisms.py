"""Closed chains with known kinematics; overconstrained ones run, and say what is redundant."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import RedundantConstraintWarning
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    Cylindrical,
    Placed,
    PrescribedRotation,
    Revolute,
    System,
    Universal,
)
from supple.simulation import simulate

TIGHT = Tolerances(residual=1e-10)


def directed(tail, head):
    """Placement of a rod along x between two points of the plane: its middle, and its rotation vector."""
    tail, head = np.asarray(tail), np.asarray(head)
    angle = np.arctan2(*(head - tail)[::-1])
    return {"position": [*(tail + head) / 2, 0.0], "rotation": [0.0, 0.0, angle]}


# A crank-rocker: ground 4, crank 1, coupler 3.5, rocker 2.5 (shortest plus longest below the other two).
GROUND_LINK, CRANK, COUPLER, ROCKER = 4.0, 1.0, 3.5, 2.5


def rocker_angle(crank_angle):
    """Angle of the rocker, from its pivot at (4, 0), by the cosine rule in the open assembly."""
    x, y = GROUND_LINK - CRANK * np.cos(crank_angle), -CRANK * np.sin(crank_angle)
    diagonal, inclination = np.hypot(x, y), np.arctan2(y, x)  # from the crank pin to the rocker's pivot
    at_pivot = np.arccos((diagonal**2 + ROCKER**2 - COUPLER**2) / (2 * diagonal * ROCKER))
    return np.pi + inclination - at_pivot


def four_bar(rod):
    pin = np.array([CRANK, 0.0])
    pivot = np.array([GROUND_LINK, 0.0])
    joint = pivot + ROCKER * np.array([np.cos(rocker_angle(0.0)), np.sin(rocker_angle(0.0))])
    z = (0, 0, 1)
    return System(
        bodies=(
            Placed(rod("crank", CRANK), **directed([0, 0], pin)),
            Placed(rod("coupler", COUPLER), **directed(pin, joint)),
            Placed(rod("rocker", ROCKER), **directed(pivot, joint)),
        ),
        joints=(
            PrescribedRotation(
                first=GROUND, second=At("crank", "left"), axis=z, angle=lambda t: t**2, name="motor"
            ),
            Revolute(first=At("crank", "right"), second=At("coupler", "left"), axis=z, name="pin"),
            Revolute(first=GROUND, second=At("rocker", "left"), axis=z, name="pivot"),
            Revolute(
                first=At("coupler", "right"), second=At("rocker", "right"), axis=z, name="closing joint"
            ),
        ),
    )


@pytest.fixture(scope="module")
def crank_rocker(rod):
    """A turn of the crank, and the warning that came with them."""
    duration = np.sqrt(2 * np.pi)
    with pytest.warns(RedundantConstraintWarning) as warned:
        solution = simulate(
            four_bar(rod),
            Run(duration=duration, output_step=duration / 200, step=FixedStep(1e-2), tolerances=TIGHT),
        )
    return solution, str(warned[0].message)


def test_four_bar_of_hinges_has_three_redundant_equations(crank_rocker):
    """Plane mechanism of spatial joints: offset and two tilts of the joint that closes the loop."""
    _, message = crank_rocker
    assert message.startswith(
        "3 redundant constraint equation(s) left out: 'closing joint' (position z), "
        "'closing joint' (tilt about x), 'closing joint' (tilt about y)."
    )


def test_rocker_follows_the_cosine_rule(crank_rocker):
    solution, _ = crank_rocker
    angle = rocker_angle(solution.times**2)
    direction = solution.bodies["rocker"].rotation[:, :2, 0]
    np.testing.assert_allclose(direction, np.column_stack([np.cos(angle), np.sin(angle)]), atol=1e-10)


def test_four_bar_stays_plane_and_closed(crank_rocker):
    """Also what the redundant equations would hold."""
    solution, _ = crank_rocker
    coupler, rocker = solution.bodies["coupler"], solution.bodies["rocker"]
    ends = [
        motion.position + length / 2 * motion.rotation[:, :, 0]
        for motion, length in ((coupler, COUPLER), (rocker, ROCKER))
    ]
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-11)
    assert np.abs(coupler.rotation[:, 2, 0]).max() < 1e-11


def test_motor_does_the_work(crank_rocker, rod):
    """Power of the motor's torque on the crank is the rate of the kinetic energy."""
    solution, _ = crank_rocker
    t = solution.times
    kinetic = np.zeros(t.size)
    for name, length in (("crank", CRANK), ("coupler", COUPLER), ("rocker", ROCKER)):
        motion = solution.bodies[name]
        kinetic += (motion.velocity**2).sum(axis=1) / 2 + length**2 / 24 * motion.angular_velocity[:, 2] ** 2
    power = -solution.multipliers["motor"][:, 5] * 2 * t
    work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(t))])
    assert np.abs(work - kinetic).max() < 5e-3 * kinetic.max()


BEND = 0.6
"""Angle between the shafts of the universal joint."""


@pytest.fixture(scope="module")
def shafts(rod, turned):
    """The driven shaft runs along x from the cross, the driving one up to it, bent in the x-y plane."""
    towards = turned(2, -BEND)
    driving = towards @ [1, 0, 0]
    bodies = (
        Placed(rod("driving", 1.0), position=-0.5 * driving, rotation=towards),
        Placed(rod("driven", 1.0), position=[0.5, 0, 0]),
    )
    joints = (
        PrescribedRotation(
            first=GROUND,
            second=At("driving", "left"),
            axis=tuple(driving),
            angle=lambda t: 2.0 * t**2,
            name="motor",
        ),
        # The cross's arm on the driving shaft lies in the plane of the shafts at the start.
        Universal(
            first=At("driving", "right"),
            second=At("driven", "left"),
            first_axis=tuple(towards @ [0, 1, 0]),
            second_axis=(0, 0, 1),
            name="cross",
        ),
        Cylindrical(first=GROUND, second=At("driven", "right"), axis=(1, 0, 0), name="bearing"),
    )
    with pytest.warns(RedundantConstraintWarning, match="2 redundant .*'bearing'"):
        return simulate(
            System(bodies, joints),
            Run(duration=1.8, output_step=0.05, step=FixedStep(2e-3), tolerances=TIGHT),
        )


@pytest.mark.slow
def test_universal_joint_turns_unevenly(shafts):
    """tan(driven) = tan(driving) / cos(bend), as the driving arm starts in the plane of the shafts."""
    driving = 2.0 * shafts.times**2
    driven = np.arctan2(np.sin(driving), np.cos(driving) * np.cos(BEND))
    rotation = shafts.bodies["driven"].rotation
    np.testing.assert_allclose(
        rotation[:, 1:, 1], np.column_stack([np.cos(driven), np.sin(driven)]), atol=1e-9
    )
    np.testing.assert_allclose(rotation[:, 0, 0], 1.0, atol=1e-12)


@pytest.mark.slow
def test_universal_joint_speed_ratio(shafts):
    """w_2 / w_1 = cos b / (1 - sin^2 b cos^2 theta), theta from the plane of the shafts."""
    driving = 2.0 * shafts.times**2
    ratio = np.cos(BEND) / (1 - np.sin(BEND) ** 2 * np.cos(driving) ** 2)
    assert ratio.max() / ratio.min() > 1.4
    speed = shafts.bodies["driven"].angular_velocity[:, 0]
    np.testing.assert_allclose(speed, ratio * 4.0 * shafts.times, atol=1e-3)
