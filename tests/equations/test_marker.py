"""Markers: kinematics against differentiation, forces against virtual power."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.algebra.rotation import rotation_exp, unskew
from supple.equations.marker import (
    N_LOCAL,
    Marker,
    displaced,
    frame_map,
    generalized_force,
    orientation,
    point,
    pose,
    with_rates,
    wrench_stiffness,
)
from supple.machine.pose import Wrench

RNG = np.random.default_rng(11)
LOCAL = np.zeros(N_LOCAL)
RATES = RNG.standard_normal(N_LOCAL)


@pytest.fixture(scope="module")
def marker():
    """In general position, the interface turned by a finite angle against its frame."""
    vectors = jnp.asarray(RNG.standard_normal((8, 3)))
    return Marker(
        origin=vectors[0],
        rotation=rotation_exp(vectors[1]),
        displacement=0.3 * vectors[2],
        rotation_vector=0.4 * vectors[3],
        cubic_turn=jnp.asarray(0.2),
        offset=vectors[4],
        axes=rotation_exp(vectors[5]),
        velocity=jnp.zeros(3),
        angular_velocity=jnp.zeros(3),
        displacement_rate=jnp.zeros(3),
        rotation_vector_rate=jnp.zeros(3),
    )


@pytest.fixture(scope="module")
def moving(marker):
    """Point, orientation and their rates while the local freedoms change at `RATES`."""

    def moved(local):
        return point(displaced(marker, local)), orientation(displaced(marker, local))

    return jax.jit(partial(jax.jvp, moved))((LOCAL,), (RATES,))


def test_point_velocity_is_the_rate_of_the_point(marker, moving):
    (_, _), (rate, _) = moving
    np.testing.assert_allclose(pose(with_rates(marker, RATES)).velocity, rate, atol=1e-14)


def test_angular_velocity_is_that_of_the_orientation(marker, moving):
    """Adot A^T = skew(w)."""
    (_, axes), (_, rate) = moving
    np.testing.assert_allclose(
        pose(with_rates(marker, RATES)).angular_velocity, unskew(rate @ axes.T), atol=1e-14
    )


def test_frame_motion_is_the_derivative_of_point_and_axes(marker, moving):
    (_, axes), (shift, rate) = moving
    motion = frame_map(marker) @ RATES
    np.testing.assert_allclose(motion[:3], shift, atol=1e-14)
    np.testing.assert_allclose(motion[3:], unskew(axes.T @ rate), atol=1e-14)


def test_generalized_force_has_the_power_of_the_wrench(marker):
    force, moment = jnp.asarray(RNG.standard_normal((2, 3)))
    fast = with_rates(marker, RATES)
    power = force @ pose(fast).velocity + moment @ pose(fast).angular_velocity
    np.testing.assert_allclose(generalized_force(marker, Wrench(force, moment)) @ RATES, power, rtol=1e-13)


def test_generalized_force_is_the_frame_motion_transposed(marker):
    force, moment = jnp.asarray(RNG.standard_normal((2, 3)))
    wrench = jnp.concatenate([force, orientation(marker).T @ moment])
    np.testing.assert_allclose(
        generalized_force(marker, Wrench(force, moment)), frame_map(marker).T @ wrench, atol=1e-13
    )


def test_wrench_stiffness_is_the_derivative_at_constant_wrench(marker):
    wrench = jnp.asarray(RNG.standard_normal(6))
    expected = jax.jit(jax.jacfwd(lambda local: frame_map(displaced(marker, local)).T @ wrench))(LOCAL)
    np.testing.assert_allclose(wrench_stiffness(marker, wrench, frame_map(marker)), expected, atol=1e-13)
