"""Lines from matrices: cleaned of round-off, and refused for what is more."""

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, beam_matrices, straight

from supple.errors import ModelError
from supple.methods.intrinsic import clamped_line, condensed_line

POINTS = straight(2.0, 4, (0.6, 0.0, 0.8))
SECTION = {"EA": 1e5, "EI": 10.0, "GJ": 8.0, "mass_per_length": 1.3, "radius": 0.02}


def test_round_off_under_rigid_motion_is_cleaned_away():
    stiffness, mass = beam_matrices(POINTS, **SECTION)
    noise = np.random.default_rng(0).standard_normal(stiffness.shape)
    noisy = stiffness.toarray() + 1e-9 * np.abs(stiffness).max() * (noise + noise.T)
    line = condensed_line("noisy", POINTS, noisy, mass)
    assert 1e-11 < line.rigid_force < 1e-7
    assert np.abs(line.stiffness @ line.twists).max() < 1e-14 * np.abs(line.stiffness).max()
    assert np.abs(line.stiffness - noisy).max() < 1e-7 * np.abs(line.stiffness).max()


def test_a_clamped_model_has_the_forces_at_its_root_by_geometry():
    stiffness, mass = beam_matrices(POINTS, **SECTION)
    line = clamped_line("clamped", POINTS, stiffness.toarray()[6:, 6:], mass.toarray()[6:, 6:])
    assert line.stiffness == pytest.approx(stiffness.toarray(), abs=1e-9 * stiffness.max())
    assert line.total_mass == pytest.approx(1.3 * 2.0 * (1 - 1 / 8))  # without the root's half segment


def test_mass_of_round_off_below_zero_is_none():
    stiffness, mass = beam_matrices(POINTS, **SECTION | {"radius": 0.0})
    given = mass.toarray()
    given[3, 3] = given[9, 9] = -1e-9
    line = condensed_line("massless", POINTS, stiffness, given)
    assert np.linalg.eigvalsh(line.mass)[0] > -1e-15


def bad(**changes):
    stiffness, mass = beam_matrices(POINTS, **SECTION)
    given = {"points": POINTS, "stiffness": stiffness.toarray(), "mass": mass.toarray()}
    return given | {name: change(given[name]) for name, change in changes.items()}


def grounded(matrix):
    return matrix + 10.0 * np.eye(len(matrix))


def skewed(matrix):
    matrix[0, 6] *= 1.1
    return matrix


def with_nan(matrix):
    matrix[0, 0] = np.nan
    return matrix


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stiffness": grounded}, "rigid motion causes forces .* clamped_line"),
        ({"points": lambda p: 1.01 * p}, "rigid motion causes forces"),
        ({"stiffness": skewed}, "stiffness is not symmetric"),
        ({"stiffness": with_nan}, "stiffness has NaN"),
        ({"stiffness": lambda k: k[6:, 6:]}, r"stiffness has shape \(24, 24\)"),
        ({"mass": lambda m: -m}, "mass is negative at station"),
        ({"mass": lambda m: 0 * m}, "has no mass"),
    ],
)
def test_matrices_that_are_no_free_body_are_refused(changes, message):
    with pytest.raises(ModelError, match=message):
        condensed_line("bad", **bad(**changes))


def test_the_mass_of_stations_is_by_blocks_where_stations_share_none():
    line = beam_line(POINTS, **SECTION)
    masses = line.station_masses
    assert masses is not None
    assert masses[:, 0, 0].sum() == pytest.approx(2.6)
    shared = line.mass.copy()
    shared[0, 6] = shared[6, 0] = 0.01
    assert condensed_line("shared", POINTS, line.stiffness, shared).station_masses is None
