"""Inertia of the condensed motion: its moments, Lagrange's equations of its energy, and the tangent."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.algebra.rotation import rotation_exp, rotation_right_jacobian
from supple.integrate import StepFactors
from supple.multibody.equations.condensed_inertia import (
    condensed_inertia,
    condensed_mass,
    condensed_momenta,
    condensed_tangent,
    unpacked_moments,
)
from supple.multibody.equations.floating_inertia import (
    FloatingState,
    floating_mass,
    inertia_arrays,
    inertia_tangent,
    inertia_terms,
)

FRAME_VELOCITY = np.array([0.4, -0.7, 0.3])
ROTATION = np.array(rotation_exp(jnp.array([0.4, -0.3, 0.9])))


@pytest.fixture(scope="module")
def moments(floating_blade):
    return unpacked_moments(floating_blade.condensed.moments)


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


def kinetic(moments, motion, velocity):
    return condensed_momenta(moments, motion, velocity).kinetic


def test_moments_are_sums_over_the_nodes(floating_blade, blade, moments, motion):
    g = motion.coordinates
    z = (floating_blade.condensed.fields @ floating_blade.condensed.amplitudes_at(g)).reshape(-1, 6)
    momentum = (blade.nodal_mass @ z.ravel()).reshape(-1, 6)
    s, c, packed = np.split(np.einsum("ijk,j,k->i", moments, g, g) / 2, [3, 6])
    np.testing.assert_allclose(s, momentum[:, :3].sum(axis=0), rtol=1e-10)
    about = np.cross(blade.nodes, momentum[:, :3]) + momentum[:, 3:]
    np.testing.assert_allclose(c, about.sum(axis=0), rtol=1e-10, atol=1e-14)
    # sum m [2 x.z I - x z^T - z x^T]: the inertia tensor of moved nodes, to first order.
    product = blade.nodes.T @ momentum[:, :3]
    tensor = 2 * np.trace(product) * np.eye(3) - product - product.T
    np.testing.assert_allclose(
        packed, tensor[np.triu_indices(3)], rtol=1e-10, atol=1e-12 * np.abs(tensor).max()
    )


def test_mass_matrix_is_the_hessian_of_the_kinetic_energy(moments, motion):
    def energy(v):
        return kinetic(moments, motion._replace(angular_velocity=v[3:6], rates=v[6:]), v[:3])

    v = jnp.concatenate([FRAME_VELOCITY, motion.angular_velocity, motion.rates])
    mass = condensed_mass(moments, jnp.asarray(motion.coordinates))
    np.testing.assert_allclose(mass, jax.jit(jax.hessian(energy))(v), atol=1e-13 * np.abs(mass).max())


def test_momenta_are_derivatives_of_the_kinetic_energy(moments, motion):
    def energy(velocity, spin):
        return kinetic(moments, motion._replace(angular_velocity=spin), velocity)

    linear, angular = jax.grad(energy, argnums=(0, 1))(
        jnp.asarray(FRAME_VELOCITY), jnp.asarray(motion.angular_velocity)
    )
    found = condensed_momenta(moments, motion, jnp.asarray(FRAME_VELOCITY))
    np.testing.assert_allclose(found.linear, linear, rtol=1e-12)
    np.testing.assert_allclose(found.angular, angular, rtol=1e-12)


def test_force_is_lagranges(moments, motion):
    """d/dt dT/dqdot - dT/dq in coordinates `(R, psi, g)` with `A = A_0 exp(psi)`, at psi = 0 but moving."""
    r = moments.shape[-1]

    def energy(q, rate):
        rotation = ROTATION @ rotation_exp(q[3:6])
        moving = FloatingState(
            q[6:],
            rotation_right_jacobian(q[3:6]) @ rate[3:6],
            rate[6:],
            jnp.zeros(3),
            jnp.zeros(3),
            jnp.zeros(r),
        )
        return kinetic(moments, moving, rotation.T @ rate[:3])

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
    computed = np.array(condensed_inertia(moments, motion).force)
    computed[:3] = ROTATION @ computed[:3]
    np.testing.assert_allclose(computed, expected, atol=1e-12 * np.abs(expected).max())


def test_tangent_is_the_derivative_of_the_force(moments, motion):
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
        return condensed_inertia(moments, moved).force

    expected = jax.jit(jax.jacfwd(force))(jnp.zeros(6 + moments.shape[-1]))
    terms = condensed_inertia(moments, motion)
    computed = condensed_tangent(moments, motion, terms, StepFactors(position, velocity))
    np.testing.assert_allclose(computed, expected, atol=1e-13 * np.abs(expected).max())


def test_it_is_added_to_the_inertia_of_the_columns(floating_blade, moments, motion):
    gram, factors = floating_blade.gram, StepFactors(0.07, 0.3)
    alone, whole = inertia_arrays(gram), inertia_arrays(gram, floating_blade.condensed.moments)
    of_columns, terms, own = (
        inertia_terms(alone, motion),
        inertia_terms(whole, motion),
        condensed_inertia(moments, motion),
    )
    np.testing.assert_allclose(terms.force, of_columns.force + own.force, rtol=1e-12)
    np.testing.assert_allclose(
        inertia_tangent(whole, motion, terms, factors),
        inertia_tangent(alone, motion, of_columns, factors)
        + condensed_tangent(moments, motion, own, factors),
        atol=1e-12,
    )
    g = jnp.asarray(motion.coordinates)
    np.testing.assert_allclose(
        floating_mass(gram, g, moments), floating_mass(gram, g) + condensed_mass(moments, g), atol=1e-14
    )
