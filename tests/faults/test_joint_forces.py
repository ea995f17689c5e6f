"""Joint forces: six components on the second end, which move every body as Newton and Euler say."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import RigidBody
from supple.integrate import JOINT_COMPONENTS, FixedStep, Run
from supple.machine import (
    GROUND,
    At,
    Fixed,
    Placed,
    PrescribedRotation,
    Prismatic,
    Revolute,
    Sine,
    System,
    Universal,
)
from supple.quantities import joint_loads, joint_meanings
from supple.simulation import simulate

GRAVITY = np.array([0.0, 0.3, -9.81])
INERTIA = np.diag([0.02, 0.03, 0.04])


def link(name, at):
    ends = {"left": np.zeros(3), "right": np.array([0.4, 0.1, 0.0])}
    return Placed(RigidBody(name, 1.5, np.array([0.2, 0.05, 0.1]), INERTIA, ends), position=np.array(at))


@pytest.fixture(scope="module")
def chain():
    """Five links of which each hangs on the one before by another joint, and their motion."""
    bodies = tuple(link(name, (0.4 * i, 0.1 * i, 0.0)) for i, name in enumerate("abcde"))
    ends = [(GROUND, At("a", "left"))] + [
        (At(one, "right"), At(other, "left")) for one, other in zip("abcd", "bcde", strict=True)
    ]
    joints = (
        Revolute(name="hinge", first=ends[0][0], second=ends[0][1], axis=(0.0, 1.0, 0.2)),
        Universal(
            name="cross",
            first=ends[1][0],
            second=ends[1][1],
            first_axis=(1.0, 0.0, 0.0),
            second_axis=(0.0, 1.0, 0.0),
        ),
        Prismatic(name="slide", first=ends[2][0], second=ends[2][1], axis=(0.3, 1.0, 0.5)),
        PrescribedRotation(
            name="motor", first=ends[3][0], second=ends[3][1], axis=(0.0, 0.0, 1.0), angle=Sine(0.5, 1.0)
        ),
        Fixed(
            name="weld", first=ends[4][0], second=ends[4][1], axis=(0.2, -0.5, 0.8), x_axis=(1.0, 0.0, 0.0)
        ),
    )
    system = System(bodies, joints, gravity=GRAVITY)
    return system, simulate(system, Run(0.2, 0.02, step=FixedStep(0.005)))


def wrench_in_space(system, solution, joint):
    """Force (t, 3), moment (t, 3) and the point (t, 3) that they are about."""
    axes = np.broadcast_to(joint.initial_axes, (len(solution.times), 3, 3))
    if joint.first != GROUND:
        start = system.bodies[system.body_index(joint.first.body)].rotation
        axes = solution.bodies[joint.first.body].rotation @ start.T @ joint.initial_axes
    motion = solution.bodies[joint.second.body]
    place = system.bodies[system.body_index(joint.second.body)].body.interface(joint.second.interface)
    point = motion.position + motion.rotation @ place.position
    parts = solution.joint_forces[joint.name]
    return *(np.einsum("tij,tj->ti", axes, part) for part in (parts[:, :3], parts[:, 3:])), point


def test_forces_and_gravity_move_every_body_as_newton_and_euler_say(chain):
    """m a = F_1 - F_2 + m g, and d(I w)/dt = the moments about the centre: of all joints, at all times."""
    system, solution = chain
    for i, placed in enumerate(system.bodies):
        body, motion = placed.body, solution.bodies[placed.body.name]
        arm = motion.rotation @ body.centre
        w, dw = (
            np.einsum("tij,tj->ti", motion.rotation, each)
            for each in (motion.angular_velocity, motion.angular_acceleration)
        )
        acceleration = motion.acceleration + np.cross(dw, arm) + np.cross(w, np.cross(w, arm))
        own_w, own_dw = motion.angular_velocity, motion.angular_acceleration
        spin = np.einsum("tij,tj->ti", motion.rotation, own_dw @ INERTIA + np.cross(own_w, own_w @ INERTIA))
        force, moment = -body.mass * (acceleration - GRAVITY), -spin
        for joint, sign in zip(system.joints[i : i + 2], (1.0, -1.0), strict=False):
            on_second, turning, point = wrench_in_space(system, solution, joint)
            force = force + sign * on_second
            moment = moment + sign * (turning + np.cross(point - motion.position - arm, on_second))
        weight = body.mass * np.linalg.norm(GRAVITY)
        assert np.abs(force).max() < 1e-6 * weight, placed.body.name
        assert np.abs(moment).max() < 1e-6 * weight, placed.body.name


def test_what_a_joint_leaves_free_carries_nothing(chain):
    _, solution = chain
    names = {name: i for i, name in enumerate(JOINT_COMPONENTS)}
    forces = solution.joint_forces
    size = np.abs(forces["hinge"]).max()
    assert np.abs(forces["hinge"][:, names["moment z"]]).max() < 1e-8 * size
    assert np.abs(forces["slide"][:, names["force z"]]).max() < 1e-8 * size
    assert np.abs(forces["motor"][:, names["moment z"]]).max() > 1e-3 * size


def test_every_place_has_the_same_sign_and_says_what_it_acts_on(chain):
    system, solution = chain
    loads, meanings = joint_loads(system, solution), joint_meanings(system)
    for joint in system.joints:
        np.testing.assert_array_equal(loads[joint.name]["force"], solution.joint_forces[joint.name][:, :3])
        np.testing.assert_array_equal(loads[joint.name]["moment"], solution.joint_forces[joint.name][:, 3:])
        assert meanings[joint.name]["acts on"] == str(joint.second)
    # What hangs is held up: the hinge carries the four links against gravity at the start's first instant.
    assert wrench_in_space(system, solution, system.joints[0])[0][0, 2] > 0


def test_a_force_at_rest_is_the_weight_upwards():
    """A body clamped to the ground: the force on it is m g upwards, its moment opposes that of the weight."""
    from supple.machine import Fixed

    body = link("a", (0.0, 0.0, 0.0))
    clamp = Fixed(name="clamp", first=GROUND, second=At("a", "left"))
    solution = simulate(
        System((body,), (clamp,), gravity=np.array([0.0, 0.0, -10.0])), Run(0.02, 0.01, step=FixedStep(0.01))
    )
    np.testing.assert_allclose(solution.joint_forces["clamp"][-1], [0, 0, 15.0, 0.75, -3.0, 0], atol=1e-9)
