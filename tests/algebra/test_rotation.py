"""Rotations against scipy's, and their derivatives against the definitions."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from supple.algebra.rotation import (
    euler_parameters,
    rotation_exp,
    rotation_log,
    rotation_right_jacobian,
    skew,
    unskew,
)

# Angles on both sides of the switch from series to closed form (0.1 rad), tiny, and near a half turn.
ANGLES = (0.0, 1e-9, 1e-4, 0.0999, 0.1001, 0.7, 2.0, 3.1)


@pytest.fixture(scope="module")
def vectors():
    """(n, 3) rotation vectors: every angle about the same few random axes."""
    axes = np.random.default_rng(3).standard_normal((4, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return np.concatenate([angle * axes for angle in ANGLES])


def test_skew_is_the_cross_product():
    v, w = np.random.default_rng(0).standard_normal((2, 3))
    np.testing.assert_allclose(skew(v) @ w, np.cross(v, w), rtol=1e-15)


def test_unskew_undoes_skew():
    v = np.array([0.3, -1.2, 2.0])
    np.testing.assert_allclose(unskew(skew(v)), v, rtol=1e-15)


def test_unskew_of_a_rotation_is_its_axis_times_the_sine():
    axis, angle = np.array([2.0, -1.0, 2.0]) / 3, 0.8
    np.testing.assert_allclose(unskew(rotation_exp(angle * axis)), np.sin(angle) * axis, rtol=1e-14)


def test_exponential_is_that_of_the_matrix(vectors):
    computed = jax.jit(jax.vmap(rotation_exp))(vectors)
    np.testing.assert_allclose(computed, [expm(np.asarray(skew(v))) for v in vectors], atol=2e-14)
    np.testing.assert_allclose(computed, Rotation.from_rotvec(vectors).as_matrix(), atol=2e-15)


def test_exponential_is_orthogonal_to_rounding(vectors):
    rotations = np.asarray(jax.jit(jax.vmap(rotation_exp))(10 * vectors))
    np.testing.assert_allclose(
        rotations @ rotations.swapaxes(1, 2), np.tile(np.eye(3), (len(vectors), 1, 1)), atol=1e-14
    )


def test_right_jacobian_is_the_derivative_of_the_exponential(vectors):
    """exp(psi)^T d exp(psi) = skew(T dpsi)."""
    direction = np.array([0.4, -0.9, 0.2])

    def both(psi):
        rotation, change = jax.jvp(rotation_exp, (psi,), (jnp.asarray(direction),))
        return rotation.T @ change, skew(rotation_right_jacobian(psi) @ direction)

    by_derivative, by_formula = jax.jit(jax.vmap(both))(vectors)
    np.testing.assert_allclose(by_formula, by_derivative, atol=2e-14)


def test_right_jacobian_is_smooth_at_zero():
    """d T(psi) at 0 is -skew(dpsi)/2."""
    change = jax.jit(jax.jacfwd(rotation_right_jacobian))(jnp.zeros(3))
    expected = np.stack([-0.5 * np.asarray(skew(e)) for e in np.eye(3)], axis=-1)
    np.testing.assert_allclose(change, expected, atol=1e-16)


def test_second_derivative_of_the_exponential_at_zero():
    """exp(psi) = I + psi~ + psi~ psi~ / 2 + .."""
    v = jnp.array([0.3, -0.5, 0.8])
    second = jax.jvp(
        lambda t: jax.jvp(lambda s: rotation_exp(s * v), (t,), (1.0,))[1], (jnp.zeros(()),), (jnp.ones(()),)
    )[1]
    np.testing.assert_allclose(second, skew(v) @ skew(v), atol=1e-15)


def test_logarithm_undoes_the_exponential(vectors):
    back = jax.jit(jax.vmap(lambda v: rotation_log(rotation_exp(v))))(vectors)
    np.testing.assert_allclose(back, vectors, atol=3e-15, rtol=1e-14)


@pytest.mark.parametrize("axis", [*np.eye(3), np.array([0.6, 0.0, -0.8]), np.array([2.0, 1.0, -2.0]) / 3])
def test_logarithm_of_a_half_turn(axis):
    """The angle is pi; the axis has two signs to choose from."""
    half_turn = 2 * np.outer(axis, axis) - np.eye(3)
    vector = np.asarray(rotation_log(jnp.asarray(half_turn)))
    np.testing.assert_allclose(np.linalg.norm(vector), np.pi, rtol=1e-12)
    np.testing.assert_allclose(abs(vector @ axis), np.pi, rtol=1e-12)


def test_logarithm_close_to_a_half_turn():
    vector = (np.pi - 1e-7) * np.array([2.0, -1.0, 2.0]) / 3
    np.testing.assert_allclose(rotation_log(rotation_exp(vector)), vector, rtol=1e-13)


def test_logarithm_can_be_differentiated_at_the_identity():
    change = jax.jit(jax.jacfwd(lambda v: rotation_log(rotation_exp(v))))(jnp.zeros(3))
    np.testing.assert_allclose(change, np.eye(3), atol=1e-15)


def test_euler_parameters_are_scipys(vectors):
    """`(e0, e)` with e0 >= 0; scipy puts the scalar last."""
    expected = Rotation.from_rotvec(vectors).as_quat(canonical=True, scalar_first=True)
    computed = np.asarray(jax.jit(jax.vmap(lambda v: euler_parameters(rotation_exp(v))))(vectors))
    np.testing.assert_allclose(computed, expected, atol=2e-15)


def test_euler_parameters_have_unit_norm_at_any_rotation():
    """All four branches of the largest parameter."""
    rotations = Rotation.random(200, random_state=5)
    parameters = np.asarray(jax.jit(jax.vmap(euler_parameters))(rotations.as_matrix()))
    np.testing.assert_allclose(np.linalg.norm(parameters, axis=1), 1.0, rtol=1e-14)
    assert set(np.argmax(abs(parameters), axis=1)) == {0, 1, 2, 3}
    back = Rotation.from_quat(parameters, scalar_first=True)
    np.testing.assert_allclose(back.as_matrix(), rotations.as_matrix(), atol=1e-14)
