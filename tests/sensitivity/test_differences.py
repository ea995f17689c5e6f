"""Central differences of fourth order, and what tells smooth functions from others."""

from __future__ import annotations

import numpy as np
import pytest

from supple.sensitivity.differences import OFFSETS, central_difference, looks_smooth


def around(function, at, step):
    return [function(at + offset * step) for offset in OFFSETS]


def test_polynomials_up_to_the_fourth_power_are_differentiated_exactly():
    def cubic(x):
        return np.array([x**4 - 2 * x**3, 7 * x])

    found = central_difference(around(cubic, 1.5, 0.25), 0.25)
    np.testing.assert_allclose(found, [4 * 1.5**3 - 6 * 1.5**2, 7], rtol=1e-13)


def test_the_error_falls_with_the_fourth_power_of_the_step():
    errors = [abs(central_difference(around(np.exp, 0.3, step), step) - np.exp(0.3)) for step in (0.08, 0.04)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.02)


@pytest.mark.parametrize(
    ("function", "smooth"),
    [
        (np.sin, True),
        (lambda x: 5.0 + 1e-3 * x**2, True),
        (abs, False),
        (lambda x: max(x, 0.0), False),
        (lambda x: float(x > 0.0), False),
        (lambda x: np.sin(4000 * x), False),
        (lambda _: np.nan, False),
    ],
)
def test_kinks_jumps_and_waves_shorter_than_the_step_are_no_smooth_functions(function, smooth):
    assert looks_smooth(function(0.0), around(function, 0.0, 3e-3)) is smooth


def test_rounding_of_what_is_zero_is_no_kink():
    noise = np.random.default_rng(3).normal(size=(5, 4)) * 1e-17
    assert looks_smooth(noise[0], list(noise[1:]))
