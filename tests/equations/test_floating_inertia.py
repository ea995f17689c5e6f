"""Inertia through the Gram matrix against the kinetic energy, Lagrange's equations and nodal sums."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.algebra.rotation import rotation_exp, rotation_right_jacobian, skew
from supple.equations.floating_inertia import (
    FloatingState,
    floating_mass,
    inertia_arrays,
    inertia_tangent,
    inertia_terms,
    kinetic_energy,
    velocity_fields,
)
from supple.integrate import StepFactors

FRAME_VELOCITY = np.array([0.4, -0.7, 0.3])
ROTATION = np.array(rotation_exp(jnp.array([0.4, -0.3, 0.9])))


@pytest.fixture(scope="module")
def motion(floating_blade):
    rng = np.random.default_rng(6)
    r = floating_blade.r
    return FloatingState(
        coordinates=0.1 * rng.standard_normal(r),
        angular_velocity=rng.standard_normal(3),
        rates=rng.standard_normal(r),
        acceleration=rng.standard_normal(3),
        angular_acceleration=rng.standard_normal(3),
        accelerations=rng.standard_normal(r),
    )


def test_mass_matrix_is_the_hessian_of_the_kinetic_energy(floating_blade, motion):
    gram = floating_blade.gram

    def energy(v):
        return kinetic_energy(gram, velocity_fields(motion.coordinates, v[:3], v[3:6], v[6:]))

    v = jnp.concatenate([FRAME_VELOCITY, motion.angular_velocity, motion.rates])
    mass = floating_mass(gram, jnp.asarray(motion.coordinates))
    np.testing.assert_allclose(mass, jax.jit(jax.hessian(energy))(v), atol=1e-13 * np.abs(mass).max())


def test_inertia_force_is_lagranges(floating_blade, motion):
    """d/dt dT/dqdot - dT/dq in coordinates `(R, psi, g)` with `A = A_0 exp(psi)`, at psi = 0 but moving.

    The velocities are `v = A^T Rdot`, `w = T(psi) psidot`; at psi = 0, T = I and dT/dt psidot = 0, so the
    quasi-velocities' equations are those of the coordinates: global force, moment, deformation.
    """
    gram = floating_blade.gram

    def energy(q, rate):
        rotation = ROTATION @ rotation_exp(q[3:6])
        spin = rotation_right_jacobian(q[3:6]) @ rate[3:6]
        return kinetic_energy(gram, velocity_fields(q[6:], rotation.T @ rate[:3], spin, rate[6:]))

    @jax.jit
    def lagrange(q, rate, acceleration):
        by_rate = jax.grad(energy, argnums=1)
        _, change = jax.jvp(by_rate, (q, rate), (rate, acceleration))
        return change - jax.grad(energy, argnums=0)(q, rate)

    q = jnp.concatenate([jnp.zeros(6), motion.coordinates])
    rate = jnp.concatenate([ROTATION @ FRAME_VELOCITY, motion.angular_velocity, motion.rates])
    acceleration = jnp.concatenate(
        [ROTATION @ motion.acceleration, motion.angular_acceleration, motion.accelerations]
    )
    expected = lagrange(q, rate, acceleration)
    computed = np.array(inertia_terms(inertia_arrays(gram), motion).force)
    computed[:3] = ROTATION @ computed[:3]
    np.testing.assert_allclose(computed, expected, atol=1e-12 * np.abs(expected).max())


def test_tangent_is_the_derivative_of_the_force(floating_blade, motion):
    arrays, r = inertia_arrays(floating_blade.gram), floating_blade.r
    velocity, position = 0.3, 0.07

    def force(change):
        moved = FloatingState(
            motion.coordinates + position * change[6:],
            motion.angular_velocity + velocity * change[3:6],
            motion.rates + velocity * change[6:],
            motion.acceleration + change[:3],
            motion.angular_acceleration + change[3:6],
            motion.accelerations + change[6:],
        )
        return inertia_terms(arrays, moved).force

    expected = jax.jit(jax.jacfwd(force))(jnp.zeros(6 + r))
    computed = inertia_tangent(arrays, motion, inertia_terms(arrays, motion), StepFactors(position, velocity))
    np.testing.assert_allclose(computed, expected, atol=1e-13 * np.abs(expected).max())


def test_steady_spin_pulls_the_frame_origin_outwards(floating_blade):
    """A body turning about a far point: force `m w x (w x c)` as seen from the frame at its origin."""
    r = floating_blade.r
    spin = np.array([0.2, -0.4, 1.5])
    still = FloatingState(np.zeros(r), spin, np.zeros(r), np.zeros(3), np.zeros(3), np.zeros(r))
    mass, centre = 1.0 * 0.1 * 0.02 * 1000.0, np.array([0.5, 0.0, 0.0])
    force = np.asarray(inertia_terms(inertia_arrays(floating_blade.gram), still).force)[:3]
    np.testing.assert_allclose(force, mass * np.cross(spin, np.cross(spin, centre)), atol=1e-12)
    turning = np.asarray(skew(spin)) @ np.asarray(skew(spin)) @ centre * mass
    np.testing.assert_allclose(force, turning, atol=1e-12)
