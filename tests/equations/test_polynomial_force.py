"""The compiled internal force against the reduced body's tensors, its energy and its tangent."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from supple.equations.polynomial_force import polynomial_energy, polynomial_force


@pytest.fixture
def coordinates(clamped_blade):
    return 0.1 * np.random.default_rng(2).standard_normal(clamped_blade.r)


def test_force_and_tangent_are_those_of_the_tensors(clamped_blade, coordinates):
    body = clamped_blade
    force, tangent = polynomial_force(body.stiffness, body.cubic, body.quartic, coordinates)
    scale = np.abs(force).max()
    np.testing.assert_allclose(force, body.tensors.internal_force(coordinates), atol=1e-13 * scale)
    np.testing.assert_allclose(tangent, body.tensors.tangent(coordinates), atol=1e-13 * np.abs(tangent).max())


def test_nonlinear_terms_matter(clamped_blade, coordinates):
    """Guards the tests here: the coordinates are large enough for every term."""
    body = clamped_blade
    linear = body.stiffness @ coordinates
    force, _ = polynomial_force(body.stiffness, body.cubic, body.quartic, coordinates)
    assert np.linalg.norm(force - linear) > 0.1 * np.linalg.norm(linear)


def test_force_is_the_gradient_of_the_energy_and_tangent_its_hessian(clamped_blade, coordinates):
    body = clamped_blade

    def energy(g):
        return polynomial_energy(body.stiffness, body.cubic, body.quartic, g)

    force, tangent = polynomial_force(body.stiffness, body.cubic, body.quartic, coordinates)
    np.testing.assert_allclose(
        force, jax.jit(jax.grad(energy))(coordinates), atol=1e-12 * np.abs(force).max()
    )
    np.testing.assert_allclose(
        tangent, jax.jit(jax.hessian(energy))(coordinates), atol=1e-12 * np.abs(tangent).max()
    )


def test_body_without_tensors_is_linear(clamped_blade, coordinates):
    force, tangent = polynomial_force(clamped_blade.stiffness, None, None, coordinates)
    np.testing.assert_array_equal(force, clamped_blade.stiffness @ coordinates)
    np.testing.assert_array_equal(tangent, clamped_blade.stiffness)
    energy = polynomial_energy(clamped_blade.stiffness, None, None, coordinates)
    np.testing.assert_allclose(energy, coordinates @ clamped_blade.stiffness @ coordinates / 2)


def test_derivatives_take_the_tangent_and_the_changes_of_the_tensors(clamped_blade, coordinates):
    """Against central differences, which are exact to h^2: along coordinates, and along the cubic terms."""
    body, direction = clamped_blade, np.random.default_rng(3).standard_normal(clamped_blade.r)

    def at(step, own=0.0):
        return polynomial_force(
            body.stiffness, (1 + own) * body.cubic, body.quartic, coordinates + step * direction
        )

    h = 1e-4
    for along in (at, lambda step: at(0.0, step), lambda step: at(2 * step, step)):
        derivative = jax.jvp(along, (0.0,), (1.0,))[1]
        for found, above, below in zip(derivative, along(h), along(-h), strict=True):
            expected = (above - below) / (2 * h)
            np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
