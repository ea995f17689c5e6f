"""One body per joint, all in one system: motions and reactions with closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import RigidBody
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    Ball,
    Cylindrical,
    Placed,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    System,
)
from supple.simulation import simulate

G = 9.81
MASS = 2.0
MOMENTS = np.array([0.3, 0.4, 0.5])
ACCELERATION = 3.0
"""Of the prescribed motions: m/s^2 and rad/s^2."""


def _lump(name, at=(0.0, 0.0, 0.0)):
    return RigidBody(name, MASS, [0, 0, 0], np.diag(MOMENTS), {"end": at})


TOP = replace(_lump("top", at=[0, 0, -0.6]), inertia=np.diag([0.3, 0.3, 0.5]))
TILT, PRECESSION = 0.5, 2.0


def top_spin():
    """Spin about the axis for steady precession: I_1 W^2 cos(tilt) - I_3 w_3 W + m g l = 0 (pivot's I_1)."""
    about_pivot = 0.3 + MASS * 0.6**2
    return (about_pivot * PRECESSION**2 * np.cos(TILT) + MASS * G * 0.6) / (0.5 * PRECESSION)


@pytest.fixture(scope="module")
def solution(turned):
    tilted = turned(1, TILT)
    bodies = (
        Placed(_lump("slider")),
        Placed(_lump("bolt"), velocity=[0, 0, 1.0], angular_velocity=[0, 0, 7.0]),
        Placed(_lump("sled")),
        Placed(_lump("crank", at=[-0.5, 0, 0]), position=[0.5, 0, 0]),
        Placed(
            TOP,
            position=tilted @ [0, 0, 0.6],
            rotation=tilted,
            velocity=np.cross([0, 0, PRECESSION], tilted @ [0, 0, 0.6]),
            # w = precession along global z, and what is missing of the spin along the body's axis
            angular_velocity=tilted.T @ [0, 0, PRECESSION] + [0, 0, top_spin() - PRECESSION * np.cos(TILT)],
        ),
    )
    joints = (
        Prismatic(first=GROUND, second=At("slider", "end"), axis=(0, 3, -4), name="ramp"),
        Cylindrical(first=GROUND, second=At("bolt", "end"), axis=(0, 0, 1), name="sleeve"),
        PrescribedTranslation(
            first=GROUND,
            second=At("sled", "end"),
            axis=(1, 0, 0),
            displacement=lambda t: ACCELERATION * t**2 / 2,
            name="push",
        ),
        PrescribedRotation(
            first=GROUND,
            second=At("crank", "end"),
            axis=(0, 0, 1),
            angle=lambda t: ACCELERATION * t**2 / 2,
            name="motor",
        ),
        Ball(first=GROUND, second=At("top", "end"), name="pivot"),
    )
    system = System(bodies, joints, gravity=(0, 0, -G))
    return simulate(
        system,
        Run(duration=1.0, output_step=0.05, step=FixedStep(1e-3), tolerances=Tolerances(residual=1e-10)),
    )


def test_prismatic_joint_lets_fall_down_the_ramp(solution):
    """Along a slope of 4 in 5 the acceleration is 4 g / 5, constant: exact for the integrator."""
    t, motion = solution.times, solution.bodies["slider"]
    expected = np.outer(0.8 * G * t**2 / 2, [0, 0.6, -0.8])
    np.testing.assert_allclose(motion.position, expected, atol=1e-9)
    np.testing.assert_allclose(motion.rotation, np.tile(np.eye(3), (t.size, 1, 1)), atol=1e-12)


def test_ramp_carries_the_weight_across_it(solution):
    """m g cos(slope) on the slider, the opposite on the ground, which is the first end."""
    across = np.linalg.norm(solution.multipliers["ramp"][:, :2], axis=1)
    np.testing.assert_allclose(across, MASS * G * 0.6, rtol=1e-7)
    np.testing.assert_allclose(solution.multipliers["ramp"][:, 2:], 0, atol=1e-8)


def test_cylindrical_joint_slides_and_spins_freely(solution):
    t, motion = solution.times, solution.bodies["bolt"]
    np.testing.assert_allclose(motion.position[:, 2], t - G * t**2 / 2, atol=1e-9)
    np.testing.assert_allclose(motion.angular_velocity, np.tile([0, 0, 7.0], (t.size, 1)), atol=1e-9)
    np.testing.assert_allclose(motion.rotation[:, 0, 0], np.cos(7 * t), atol=1e-9)
    np.testing.assert_allclose(solution.multipliers["sleeve"], 0, atol=1e-8)


def test_prescribed_translation_needs_the_force_mass_times_acceleration(solution):
    t, motion = solution.times, solution.bodies["sled"]
    np.testing.assert_allclose(motion.position[:, 0], ACCELERATION * t**2 / 2, atol=1e-12)
    forces = solution.multipliers["push"]
    # On the ground: against the push along z of the joint (global x), and the weight.
    np.testing.assert_allclose(forces[:, 2], -MASS * ACCELERATION, rtol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(forces[:, :2], axis=1), MASS * G, rtol=1e-7)


def test_push_through_the_centre_of_mass_needs_no_moment(solution):
    """Moments of a joint are taken about the second end's point."""
    np.testing.assert_allclose(solution.multipliers["push"][:, 3:], 0, atol=1e-7)


def test_prescribed_rotation_needs_the_torque_inertia_times_acceleration(solution):
    """About the pivot (I + m l^2) alpha; radially m l w^2, across m l alpha; on the ground reversed."""
    t, arm = solution.times, 0.5
    forces, motion = solution.multipliers["motor"], solution.bodies["crank"]
    angle = ACCELERATION * t**2 / 2
    along = np.column_stack([np.cos(angle), np.sin(angle), 0 * t])
    across = np.column_stack([-np.sin(angle), np.cos(angle), 0 * t])
    np.testing.assert_allclose(motion.position, arm * along, atol=1e-9)
    np.testing.assert_allclose(forces[1:, 5], -(MOMENTS[2] + MASS * arm**2) * ACCELERATION, rtol=1e-4)
    radial = MASS * arm * (ACCELERATION * t) ** 2
    np.testing.assert_allclose(np.sum(forces[:, :3] * along, axis=1), radial, atol=1e-2)
    np.testing.assert_allclose(
        np.sum(forces[:, :3] * across, axis=1)[1:], -MASS * arm * ACCELERATION, rtol=2e-2
    )
    np.testing.assert_allclose(forces[:, 2], -MASS * G, rtol=1e-6)


def test_heavy_top_precesses_steadily(solution):
    """The axis turns about the vertical at the rate that belongs to its spin; the tilt stays."""
    t = solution.times
    axis = solution.bodies["top"].rotation[:, :, 2]
    expected = np.column_stack(
        [np.sin(TILT) * np.cos(PRECESSION * t), np.sin(TILT) * np.sin(PRECESSION * t), np.cos(TILT) + 0 * t]
    )
    np.testing.assert_allclose(axis, expected, atol=2e-4)
