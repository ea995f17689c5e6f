"""The U on stations: which of them share stiffness, and how its eigenvalues come to those of the solid."""

import numpy as np
import pytest

from supple.errors import ModelError
from supple_benchmarks.intrinsic.u_beam import of_beam_elements, on_stations, solid_u
from supple_benchmarks.intrinsic.u_spectrum import eigenvalue_differences, stiffness_pattern

N_LEG = 8


@pytest.fixture(scope="module")
def solid():
    return solid_u(N_LEG)


@pytest.fixture(scope="module")
def bodies(solid):
    return {n: on_stations(solid, n) for n in (7, 13)}


@pytest.fixture(scope="module")
def beams(bodies):
    return of_beam_elements(bodies[13].line, N_LEG)


@pytest.mark.parametrize("n_stations", [1, 3, 8])
def test_stations_that_do_not_divide_the_legs_equally_are_refused(solid, n_stations):
    with pytest.raises(ModelError, match=f"{n_stations} stations cannot divide"):
        on_stations(solid, n_stations)


def test_beams_couple_neighbours_alone_and_a_condensed_solid_far_stations_too(bodies, beams):
    banded = np.array(stiffness_pattern(beams.line), dtype=float)
    full = np.array(stiffness_pattern(bodies[13].line), dtype=float)
    number = np.arange(13)
    far = np.abs(number[:, None] - number) > 1
    assert np.isnan(banded[far]).all()
    assert np.isfinite(banded[~far]).all()
    # Weaker from station to station; between the two ends rounding decides whether it is zero.
    assert np.isfinite(full[np.abs(number[:, None] - number) < 12]).all()
    assert np.nanmax(full) == 0
    assert np.nanmax(full[far]) < full[~far].max()


def test_low_eigenvalues_come_to_those_of_the_solid_as_stations_are_added(solid, bodies, beams):
    found = eigenvalue_differences(solid, bodies, beams)
    coarse, fine = (np.abs(found["stations"][n][:3]) for n in ("7", "13"))
    assert (fine < 0.5 * coarse).all()
    assert fine.max() < 0.03
    ratio = (1 + np.array(found["beside_beam_elements"])) * (1 + np.array(found["beam_elements"]))
    assert ratio == pytest.approx(1 + np.array(found["stations"]["13"]), rel=1e-4)


def test_beams_of_the_same_stations_weigh_what_the_solid_does(bodies, beams):
    # From the end of one leg through the corners to the end of the other: the volume of all cells.
    assert beams.mass == pytest.approx(bodies[13].mass, rel=1e-9)
