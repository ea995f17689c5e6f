"""The cubic spline through rows."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from supple.errors import ModelError
from supple.machine import Spline

TIMES = np.array([0.0, 0.4, 1.0, 1.1, 2.0])
VALUES = np.array([0.0, 1.0, -0.5, 2.0, 0.3])
BETWEEN = np.linspace(0.0, 2.0, 41)


def test_spline_is_that_of_scipy():
    expected = CubicSpline(TIMES, VALUES, bc_type="not-a-knot")
    law = Spline(TIMES, VALUES)
    np.testing.assert_allclose(jax.jit(jax.vmap(law))(BETWEEN), expected(BETWEEN), atol=1e-14)
    np.testing.assert_allclose(
        jax.jit(jax.vmap(jax.grad(law)))(BETWEEN[1:-1]), expected(BETWEEN[1:-1], 1), atol=1e-12
    )


def test_speed_and_acceleration_at_the_ends_are_those_of_the_motion():
    rows = np.linspace(0.0, 2.0, 6)
    law = Spline(rows, rows**3 - 2.0 * rows**2 + 1.5 * rows)  # a cubic has one spline: itself
    for time, speed, acceleration in ((0.0, 1.5, -4.0), (2.0, 5.5, 8.0)):
        assert float(jax.grad(law)(time)) == pytest.approx(speed, abs=1e-12)
        assert float(jax.grad(jax.grad(law))(time)) == pytest.approx(acceleration, abs=1e-11)


def test_a_jump_overshoots_and_a_turn_in_the_last_piece_does_not():
    rows = np.linspace(0.0, 5.0, 11)
    assert Spline(rows, np.sin(rows)).excursions().max() < 0.01  # largest displacement between the last rows
    for jump in (0, 4, 9):
        assert Spline(rows, 1.0 * (np.arange(11) > jump)).excursions().max() > 0.04


def test_spline_of_vectors_is_one_of_each_component():
    values = np.column_stack([VALUES, -2.0 * VALUES, VALUES**2])
    own = jax.jit(jax.vmap(Spline(TIMES, values)))(BETWEEN)
    each = [jax.jit(jax.vmap(Spline(TIMES, column)))(BETWEEN) for column in values.T]
    np.testing.assert_allclose(own, np.column_stack(each), atol=1e-14)


def test_spline_stays_at_its_end_values():
    law = Spline(TIMES, VALUES)
    assert float(law(-3.0)) == VALUES[0]
    assert float(law(7.0)) == pytest.approx(VALUES[-1], abs=1e-14)


def test_two_rows_are_joined_by_a_straight_line():
    assert float(Spline([1.0, 3.0], [2.0, 6.0])(1.5)) == pytest.approx(3.0, abs=1e-15)


def test_other_values_have_other_coefficients():
    law = replace(Spline(TIMES, VALUES), values=2.0 * VALUES)
    assert float(law(0.7)) == pytest.approx(2.0 * float(Spline(TIMES, VALUES)(0.7)), abs=1e-14)


@pytest.mark.parametrize(
    ("times", "values", "message"),
    [
        ([0.0], [1.0], "at least two times and one row of values for each"),
        ([0.0, 1.0], [1.0, np.nan], "has NaN or infinite entries"),
        ([0.0, 1.0, 1.0], [0.0, 1.0, 2.0], r"times of a table must increase: row 2 has 1.0 after 1.0"),
    ],
)
def test_wrong_rows_are_refused(times, values, message):
    with pytest.raises(ModelError, match=message):
        Spline(times, values)
