"""Blade stations: the frame of the loft, and the error messages."""

import numpy as np
import pytest

from supple.errors import MeshError
from supple.mesh import AirfoilSection, BladeStations
from supple.mesh.blade_stations import SHAPE_POINTS

DIAMOND = AirfoilSection("diamond", np.array([[1, 0], [0.5, -0.1], [0, 0], [0.5, 0.1], [1, 0]]))
THICK = AirfoilSection("thick", DIAMOND.outline * [1, 2])


def stations(**changes):
    given = {"span": [0, 4, 10], "sections": (DIAMOND,) * 3, "chord": [2, 2, 1], "twist": [0.2, 0.1, 0]}
    return BladeStations(**{**given, "pitch_axis": [0.5, 0.4, 0.4], **changes})


def test_curves_pass_through_the_stations():
    blade = stations(prebend=[0, 0, -1], sweep=0.3)
    chord, twist, axis, prebend, sweep = blade.curves([0, 4, 10])
    np.testing.assert_allclose(chord, [2, 2, 1])
    np.testing.assert_allclose(twist, [0.2, 0.1, 0], atol=1e-16)
    np.testing.assert_allclose(axis, [0.5, 0.4, 0.4])
    np.testing.assert_allclose(prebend, [0, 0, -1])
    np.testing.assert_allclose(sweep, 0.3)


def test_curves_do_not_overshoot():
    """Two equal chords stay equal in between; a spline through them would not."""
    np.testing.assert_allclose(stations().curves(np.linspace(0, 4, 9))[0], 2, rtol=1e-15)


def test_shapes_blend_along_the_span():
    shapes = stations(sections=(DIAMOND, DIAMOND, THICK)).shapes([0, 2, 7, 10])
    thin = DIAMOND.heights(SHAPE_POINTS)
    np.testing.assert_allclose(shapes[[0, 1, 3]], [thin, thin, 2 * thin], atol=1e-15)
    assert (shapes[2, 1, 1:-1] > thin[1, 1:-1]).all()
    assert (shapes[2, 1, 1:-1] < 2 * thin[1, 1:-1]).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"span": [0]}, "at least two stations"),
        ({"sections": (DIAMOND,)}, "1 sections for 3 stations"),
        ({"chord": [1, 2]}, "chord has shape"),
        ({"twist": [0.2, np.nan, 0]}, "station 1: twist is nan"),
        ({"span": [0, np.inf, 10]}, "station 1: span is inf"),
        ({"span": [0, 10, 4]}, "out of order: station 2 at 4 follows one at 10"),
        ({"span": [0, 4, 4]}, "out of order"),
        ({"chord": [2, 0, 1]}, "station 1: chord is 0"),
    ],
)
def test_errors(changes, message):
    with pytest.raises(MeshError, match=message):
        stations(**changes)
