"""A free rigid body whose frame is not at its centre of mass: Euler's equations and free fall."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj

from supple.body import RigidBody
from supple.equations.checks.energy import balances
from supple.integrate import FixedStep, GeneralizedAlpha, HilberHughesTaylor, Newmark, Run, Tolerances
from supple.machine import Placed, System
from supple.simulation import simulate

INERTIA = np.array([1.0, 2.0, 2.5])
SPIN = np.array([1.0, 0.0, 1.3])
CENTRE = np.array([0.3, -0.2, 0.1])
VELOCITY, GRAVITY = np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, -9.81])


def jacobi_spin(t):
    """Free rotation of an asymmetric body with `w_2(0) = 0` (Landau & Lifshitz, Mechanics, section 37)."""
    I1, I2, I3 = INERTIA
    energy, square = INERTIA @ SPIN**2, np.sum((INERTIA * SPIN) ** 2)  # 2 E and M^2
    assert square > energy * I2  # the branch of rotation about the third axis
    rate = np.sqrt((I3 - I2) * (square - energy * I1) / (I1 * I2 * I3))
    m = (I2 - I1) * (energy * I3 - square) / ((I3 - I2) * (square - energy * I1))
    sn, cn, dn, _ = ellipj(rate * t, m)
    second = np.sqrt((energy * I3 - square) / (I2 * (I3 - I2)))
    return np.column_stack([SPIN[0] * cn, second * sn, SPIN[2] * dn])


@pytest.fixture(scope="module")
def tumbling():
    """Thrown so that its centre of mass starts at the origin with the velocity given."""
    stone = RigidBody("stone", 3.0, CENTRE, np.diag(INERTIA))
    placed = Placed(
        stone, position=-CENTRE, velocity=VELOCITY - np.cross(SPIN, CENTRE), angular_velocity=SPIN
    )
    return System((placed,), gravity=GRAVITY)


@pytest.fixture(scope="module")
def run(tumbling):
    tight = Tolerances(residual=1e-12)

    def at_step(h, method=GeneralizedAlpha()):  # noqa: B008 (it is immutable)
        return simulate(
            tumbling, Run(duration=4.0, output_step=0.1, step=FixedStep(h), method=method, tolerances=tight)
        )

    return at_step


def errors(solution):
    """Largest errors of spin and of the centre of mass."""
    motion, t = solution.bodies["stone"], solution.times
    spin = np.abs(motion.angular_velocity - jacobi_spin(t)).max()
    centre = motion.position + motion.rotation @ CENTRE
    fall = np.outer(t, VELOCITY) + np.outer(t**2 / 2, GRAVITY)
    return np.array([spin, np.abs(centre - fall).max()])


@pytest.mark.parametrize(
    "method", [GeneralizedAlpha(), GeneralizedAlpha(0.3), Newmark(), HilberHughesTaylor(0.1)], ids=str
)
def test_spin_and_fall_converge_at_order_two(run, method):
    coarse, fine = errors(run(0.02, method)), errors(run(0.01, method))
    np.testing.assert_allclose(np.log2(coarse / fine), 2.0, atol=0.1)
    assert (fine < 2e-3).all()


def test_energy_and_angular_momentum_are_kept_at_order_two(run, tumbling):
    """About the moving centre of mass the moment of momentum is constant; gravity's work is potential."""

    def drift(h):
        solution = run(h)
        kept = balances(tumbling, solution)
        motion = solution.bodies["stone"]
        momentum = np.einsum("tij,j,tj->ti", motion.rotation, INERTIA, motion.angular_velocity)
        return np.array([np.ptp(kept.total) / kept.kinetic[0], np.abs(momentum - momentum[0]).max()])

    coarse, fine = drift(0.02), drift(0.01)
    np.testing.assert_allclose(np.log2(coarse / fine), 2.0, atol=0.15)


def test_momentum_of_the_thrown_body_is_that_of_its_mass(run, tumbling):
    """P = m v_c exactly known from the fall; so is the moment of momentum about the origin."""
    solution = run(0.0025)
    kept, t = balances(tumbling, solution), solution.times
    velocity = VELOCITY + np.outer(t, GRAVITY)
    np.testing.assert_allclose(kept.momentum, 3.0 * velocity, atol=2e-3)
    centre = np.outer(t, VELOCITY) + np.outer(t**2 / 2, GRAVITY)
    motion = solution.bodies["stone"]
    own = np.einsum("tij,j,tj->ti", motion.rotation, INERTIA, motion.angular_velocity)
    np.testing.assert_allclose(kept.angular_momentum, 3.0 * np.cross(centre, velocity) + own, atol=2e-2)


def test_rotation_stays_orthogonal(run):
    rotations = run(0.01).bodies["stone"].rotation
    np.testing.assert_allclose(
        rotations @ rotations.swapaxes(1, 2), np.tile(np.eye(3), (41, 1, 1)), atol=1e-13
    )
