"""Tables: straight lines between rows, and what is refused."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from supple.machine import Spline, Table


def test_table_interpolates_linearly():
    times, values = [0.0, 1.0, 3.0, 3.5], [0.0, 2.0, -2.0, 5.0]
    at = np.array([0.0, 0.25, 1.0, 2.9, 3.5])
    np.testing.assert_allclose(
        jax.jit(jax.vmap(Table(times, values)))(at), np.interp(at, times, values), atol=1e-15
    )


def test_table_of_vectors():
    table = Table([0.0, 2.0], np.array([[0.0, 1.0, 2.0], [4.0, 5.0, 6.0]]))
    np.testing.assert_allclose(table(0.5), [1.0, 2.0, 3.0])


@pytest.mark.parametrize("law", [Table, Spline])
@pytest.mark.parametrize("count", [2, 3])
def test_rows_of_vectors_at_an_array_of_times(law, count):
    vectors = law([0.0, 1.0, 2.0], [[0.0, 0.0, 0.0], [1.0, 2.0, 4.0], [1.0, 1.0, 1.0]])
    times = np.linspace(0.1, 1.3, count)
    np.testing.assert_allclose(vectors(times), [vectors(time) for time in times], rtol=1e-14)


def test_table_rate_is_the_slope():
    table = Table([0.0, 1.0, 3.0], [0.0, 2.0, 8.0])
    assert float(jax.jit(jax.grad(table))(2.0)) == 3.0


def test_table_numbers_may_differ_between_cases():
    """A table is a pytree: its values can be mapped over."""
    values = np.array([[0.0, 1.0], [0.0, 3.0]])
    at_half = jax.jit(jax.vmap(lambda v: Table(np.array([0.0, 1.0]), v)(0.5)))(values)
    np.testing.assert_allclose(at_half, [0.5, 1.5])


@pytest.mark.parametrize(
    ("times", "values"), [([0.0], [1.0]), ([0.0, 1.0], [1.0, 2.0, 3.0]), ([[0.0, 1.0]], [[1.0, 2.0]])]
)
def test_table_of_the_wrong_shape(times, values):
    with pytest.raises(ValueError, match="a table needs at least two times and one row of values for each"):
        Table(times, values)


def test_table_with_nan():
    with pytest.raises(ValueError, match="a table of a quantity over time has NaN or infinite entries"):
        Table([0.0, 1.0], [0.0, float("nan")])


@pytest.mark.parametrize("times", [[0.0, 1.0, 1.0], [0.0, 2.0, 1.0]])
def test_table_whose_times_do_not_increase(times):
    with pytest.raises(ValueError, match=r"times of a table must increase: row 2 has 1.0 after"):
        Table(times, [0.0, 1.0, 2.0])
