"""Vectors in axes that turn, against Rodrigues' formula."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.machine import Table, Turning


def test_turning_vectors_are_rotated_by_rodrigues():
    """v(t) = R(axis, angle(t)) v: a quarter turn about z takes x to y; the axis itself stays."""
    law = Turning([[1.0, 0.0, 0.0], [0.0, 0.0, 2.0]], (0.0, 0.0, 1.0), lambda t: 0.5 * jnp.pi * t)
    np.testing.assert_allclose(law(1.0), [[0.0, 1.0, 0.0], [0.0, 0.0, 2.0]], atol=1e-15)
    np.testing.assert_allclose(law(2.0), [[-1.0, 0.0, 0.0], [0.0, 0.0, 2.0]], atol=1e-15)


def test_turning_is_the_rotation_of_scipy_at_any_angle():
    rng = np.random.default_rng(3)
    axis, vectors = rng.normal(size=3), rng.normal(size=(5, 3))
    axis /= np.linalg.norm(axis)
    expected = Rotation.from_rotvec(0.7 * axis).apply(vectors)
    np.testing.assert_allclose(Turning(vectors, axis, 0.7)(0.0), expected, atol=1e-14)


def test_turning_table_is_exact_between_its_rows():
    """Constant vectors in turning axes: no corner is cut, however far apart the rows."""
    table = Table([0.0, 10.0], np.array([[0.0, 3.0, 0.0]] * 2))
    law = Turning(table, (1.0, 0.0, 0.0), lambda t: 8.0 * t)
    for time in (0.3, 4.7):
        np.testing.assert_allclose(law(time), [0.0, 3 * np.cos(8 * time), 3 * np.sin(8 * time)], atol=1e-12)
    assert (law.begin, law.end) == (0.0, 10.0)


def test_turning_needs_a_unit_axis():
    with pytest.raises(ValueError, match="must be a unit vector"):
        Turning([1.0, 0.0, 0.0], (1.0, 1.0, 0.0), 0.0)
