"""One body per load, all free or hinged in one system: oscillations, damping, dead and follower forces."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import RigidBody
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    ConstantRate,
    DeadForce,
    DeadTorque,
    FollowerForce,
    FollowerTorque,
    Placed,
    Revolute,
    SpringDamper,
    System,
    TorsionSpringDamper,
)
from supple.simulation import simulate

MASS, INERTIA = 2.0, 0.5
STIFFNESS, DAMPING = 50.0, 1.2
TORSION, TORSION_DAMPING, REST = 8.0, 0.1, 0.3
SPIN, FORCE, TORQUE, ARM = 3.0, 4.0, 1.5, 0.2


def _lump(name, at=(0.0, 0.0, 0.0)):
    return RigidBody(name, MASS, [0, 0, 0], INERTIA * np.eye(3), {"eye": at})


@pytest.fixture(scope="module")
def solution():
    eye = {name: At(name, "eye") for name in ("bouncer", "wheel", "rocket", "puck", "plate")}
    # The bouncer's spring is 1 m long and stretched by 0.1 m at the start.
    bodies = (
        Placed(_lump("bouncer"), position=[1.1, 0, 0]),
        Placed(_lump("wheel")),
        Placed(_lump("rocket"), angular_velocity=[0, 0, SPIN]),
        Placed(_lump("puck", at=[ARM, 0, 0])),
        Placed(_lump("plate"), rotation=[0, np.pi / 2, 0]),
    )
    loads = (
        SpringDamper(
            first=GROUND,
            second=eye["bouncer"],
            anchor=(0, 0, 0),
            stiffness=STIFFNESS,
            damping=DAMPING,
            rest_length=1.0,
        ),
        TorsionSpringDamper(
            first=GROUND,
            second=eye["wheel"],
            axis=(0, 1, 0),
            stiffness=TORSION,
            damping=TORSION_DAMPING,
            rest_angle=REST,
        ),
        FollowerForce(first=eye["rocket"], force=[FORCE, 0, 0]),
        DeadForce(body="puck", at="eye", force=ConstantRate(np.array([0.0, 0.0, FORCE]))),
        DeadTorque(first=eye["puck"], torque=lambda t: jnp.array([0.0, 0.0, TORQUE * jnp.cos(t)])),
        FollowerTorque(first=eye["plate"], torque=[0, 0, TORQUE]),
        DeadForce(body="plate", at="eye", force=[0, FORCE, 0]),
    )
    hinge = Revolute(first=GROUND, second=eye["wheel"], axis=(0, 1, 0), name="hinge")
    system = System(bodies, (hinge,), loads)
    return simulate(
        system,
        Run(duration=1.0, output_step=0.05, step=FixedStep(1e-3), tolerances=Tolerances(residual=1e-10)),
    )


def damped(t, start, rate, ratio):
    """Free oscillation from rest at `start`."""
    fast = rate * np.sqrt(1 - ratio**2)
    return start * np.exp(-ratio * rate * t) * (np.cos(fast * t) + ratio * rate / fast * np.sin(fast * t))


def test_spring_and_damper_oscillate_at_their_frequency(solution):
    """x = 1 + 0.1 exp(-zeta w t) (cos + ..), w = sqrt(k / m), zeta = c / (2 m w)."""
    rate = np.sqrt(STIFFNESS / MASS)
    expected = 1 + damped(solution.times, 0.1, rate, DAMPING / (2 * MASS * rate))
    np.testing.assert_allclose(solution.bodies["bouncer"].position[:, 0], expected, atol=1e-5)
    np.testing.assert_allclose(solution.bodies["bouncer"].position[:, 1:], 0, atol=1e-12)


def test_torsion_spring_oscillates_about_its_rest_angle(solution):
    rate = np.sqrt(TORSION / INERTIA)
    angle = REST + damped(solution.times, -REST, rate, TORSION_DAMPING / (2 * INERTIA * rate))
    rotation = solution.bodies["wheel"].rotation
    np.testing.assert_allclose(np.arctan2(rotation[:, 0, 2], rotation[:, 0, 0]), angle, atol=1e-5)


def test_follower_force_turns_with_its_body(solution):
    """a = F/m (cos wt, sin wt): x = F/(m w^2) (1 - cos wt), y = F/(m w^2) (wt - sin wt)."""
    turn, size = SPIN * solution.times, FORCE / (MASS * SPIN**2)
    expected = size * np.column_stack([1 - np.cos(turn), turn - np.sin(turn), 0 * turn])
    np.testing.assert_allclose(solution.bodies["rocket"].position, expected, atol=2e-6)


def test_dead_force_keeps_its_direction_and_turns_the_body_it_acts_on_off_centre(solution):
    """F t along z on m: z = F t^3 / (6 m), whatever the rotation; a sphere under the moments r x F + M."""
    t, motion = solution.times, solution.bodies["puck"]
    np.testing.assert_allclose(motion.position[:, 2], FORCE * t**3 / (6 * MASS), atol=1e-6)
    arm = ARM * motion.rotation[:, :, 0]
    moment = np.cross(arm, np.outer(FORCE * t, [0, 0, 1])) + np.outer(TORQUE * np.cos(t), [0, 0, 1])
    acceleration = np.einsum("tij,tj->ti", motion.rotation, motion.angular_acceleration)
    np.testing.assert_allclose(INERTIA * acceleration, moment, atol=1e-8)


def test_dead_torque_spins_a_sphere_about_a_fixed_direction(solution):
    """The dead force has no moment about z: I w_z = M sin t, in global components."""
    motion = solution.bodies["puck"]
    spin = np.einsum("tij,tj->ti", motion.rotation, motion.angular_velocity)
    np.testing.assert_allclose(spin[:, 2], TORQUE / INERTIA * np.sin(solution.times), atol=1e-6)


def test_follower_torque_acts_along_the_interfaces_axes(solution):
    """Global components at the start; the body turns about that axis, which therefore stays: exact."""
    t, motion = solution.times, solution.bodies["plate"]
    spin = np.einsum("tij,tj->ti", motion.rotation, motion.angular_velocity)
    np.testing.assert_allclose(spin, np.outer(TORQUE / INERTIA * t, [0, 0, 1]), atol=1e-9)
    np.testing.assert_allclose(motion.position, np.outer(FORCE / (2 * MASS) * t**2, [0, 1, 0]), atol=1e-9)
