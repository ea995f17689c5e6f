"""Rotor: polars along the radius, and the error messages."""

import numpy as np
import pytest

from supple.aero import Rotor
from supple.errors import ModelError


@pytest.fixture
def given(thin_airfoil):
    return {
        "radius": [1.0, 2.0, 4.0],
        "chord": [0.4, 0.4, 0.2],
        "twist": [0.2, 0.1, 0.0],
        "polars": (thin_airfoil,) * 3,
        "n_blades": 3,
    }


def test_polars_at_the_stations_are_the_stations_own(rotor):
    polars = rotor.polars_at(rotor.radius)
    for section, polar in enumerate(rotor.polars):
        lift, drag = polars.coefficients(np.full(polar.angle.size, section), polar.angle)
        np.testing.assert_allclose(lift, polar.lift, atol=1e-14)
        np.testing.assert_allclose(drag, polar.drag, atol=1e-14)


def test_tip_is_the_last_station(rotor):
    assert rotor.tip_radius == 63.0


@pytest.mark.parametrize("radius", [0.9, 4.1, np.nan])
def test_radius_off_the_blade(given, radius):
    with pytest.raises(ModelError, match="lies off the blade, which runs from 1 to 4"):
        Rotor(**given).polars_at([2.0, radius])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": [1.0]}, "radius has shape|chord has shape"),
        ({"chord": [0.4, 0.4]}, "chord has shape"),
        ({"twist": [0.2, np.inf, 0.0]}, "twist of station 1 is inf"),
        ({"polars": ()}, "0 polars for 3 stations"),
        ({"radius": [1.0, 4.0, 2.0]}, "radius 2 of station 2 is out of order"),
        ({"radius": [0.0, 2.0, 4.0]}, "radius 0 of station 0"),
        ({"chord": [0.4, -0.4, 0.2]}, "chord -0.4 of station 1"),
        ({"n_blades": 0}, "0 blades"),
    ],
)
def test_errors(given, changes, message):
    with pytest.raises(ModelError, match=message):
        Rotor(**{**given, **changes})
