"""Polars: interpolation and blending are exact on piecewise linear data; error messages."""

import numpy as np
import pytest

from supple.aero import Polar
from supple.aero.polar import blend_polars
from supple.errors import ModelError

FLAT = Polar("flat", [-1.0, 0.0, 2.0], [-0.5, 0.0, 1.0], [0.1, 0.0, 0.2])
STEEP = Polar("steep", [-0.5, 1.5], [-2.0, 6.0], [0.3, 0.3])


def test_blend_is_linear_between_polars():
    part = np.array([0.0, 0.25, 1.0])
    blend = blend_polars((FLAT, STEEP), np.zeros(3, int), part)
    angle = np.linspace(-0.4, 1.4, 13)
    section = np.repeat(np.arange(3), angle.size)
    lift, drag = blend.coefficients(section, np.tile(angle, 3))
    for values, name in ((lift, "lift"), (drag, "drag")):
        ends = [np.interp(angle, polar.angle, getattr(polar, name)) for polar in (FLAT, STEEP)]
        expected = np.outer(1 - part, ends[0]) + np.outer(part, ends[1])
        np.testing.assert_allclose(values, expected.ravel(), atol=1e-15)


def test_coverage_is_that_of_the_polars_in_use():
    blend = blend_polars((FLAT, STEEP), np.zeros(3, int), np.array([0.0, 0.5, 1.0]))
    np.testing.assert_array_equal(blend.lowest, [-1.0, -0.5, -0.5])
    np.testing.assert_array_equal(blend.highest, [2.0, 1.5, 1.5])


@pytest.mark.parametrize(
    ("angle", "lift", "drag", "message"),
    [
        ([0.0], [0.0], [0.0], "at least two"),
        ([0.0, 1.0], [0.0], [0.0, 1.0], "2 angles, 1 lift and 2 drag"),
        ([0.0, 1.0], [0.0, np.nan], [0.0, 1.0], "row 1 is not finite"),
        ([0.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 1.0, 1.0], "out of order in row 2, 28.6479 deg"),
    ],
)
def test_errors(angle, lift, drag, message):
    with pytest.raises(ModelError, match=f"polar 'bad': .*{message}"):
        Polar("bad", angle, lift, drag)
