"""Laws of time: values, ends, and what is refused."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.machine import Constant, Table, TimeFunction, Turning
from supple.machine.laws.time_law import as_time_law


def test_table_interpolates_linearly():
    times, values = [0.0, 1.0, 3.0, 3.5], [0.0, 2.0, -2.0, 5.0]
    at = np.array([0.0, 0.25, 1.0, 2.9, 3.5])
    np.testing.assert_allclose(jax.vmap(Table(times, values))(at), np.interp(at, times, values), atol=1e-15)


def test_table_of_vectors():
    table = Table([0.0, 2.0], np.array([[0.0, 1.0, 2.0], [4.0, 5.0, 6.0]]))
    np.testing.assert_allclose(table(0.5), [1.0, 2.0, 3.0])


def test_table_rate_is_the_slope():
    table = Table([0.0, 1.0, 3.0], [0.0, 2.0, 8.0])
    assert float(jax.grad(table)(2.0)) == 3.0


def test_only_tables_end():
    table = Table([0.5, 2.0], [1.0, 1.0])
    assert (table.begin, table.end) == (0.5, 2.0)
    assert Constant(3.0).begin == TimeFunction(jnp.sin).begin == float("-inf")
    assert Constant(3.0).end == TimeFunction(jnp.sin).end == float("inf")


def test_table_numbers_may_differ_between_cases():
    """A table is a pytree: its values can be mapped over."""
    values = np.array([[0.0, 1.0], [0.0, 3.0]])
    at_half = jax.vmap(lambda v: Table(np.array([0.0, 1.0]), v)(0.5))(values)
    np.testing.assert_allclose(at_half, [0.5, 1.5])


def test_law_of_a_law_a_function_and_a_number():
    table = Table([0.0, 1.0], [0.0, 1.0])
    assert as_time_law(table) is table
    assert float(as_time_law(lambda t: 2 * t)(3.0)) == 6.0
    assert float(as_time_law(2.5)(7.0)) == 2.5
    np.testing.assert_array_equal(as_time_law([1.0, 2.0, 3.0])(0.0), [1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("times", "values"), [([0.0], [1.0]), ([0.0, 1.0], [1.0, 2.0, 3.0]), ([[0.0, 1.0]], [[1.0, 2.0]])]
)
def test_table_of_the_wrong_shape(times, values):
    with pytest.raises(ValueError, match="a table needs at least two times and one row of values for each"):
        Table(times, values)


def test_table_with_nan():
    with pytest.raises(ValueError, match="a table of a quantity over time holds NaN or infinite entries"):
        Table([0.0, 1.0], [0.0, float("nan")])


@pytest.mark.parametrize("times", [[0.0, 1.0, 1.0], [0.0, 2.0, 1.0]])
def test_table_whose_times_do_not_increase(times):
    with pytest.raises(ValueError, match=r"times of a table must increase: row 2 has 1.0 after"):
        Table(times, [0.0, 1.0, 2.0])


def test_constant_with_nan():
    with pytest.raises(ValueError, match="a constant quantity holds NaN or infinite entries"):
        as_time_law([0.0, float("inf"), 0.0])


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
