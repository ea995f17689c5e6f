"""Modes as functions along a line: orthonormal on the grid, and those of the analytic cantilever."""

from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.errors import AccuracyError, ModelError
from supple.methods.intrinsic import BALL, CLAMPED, FREE, condensed_line, hinged, intrinsic_modes, sliding
from supple.methods.intrinsic.intrinsic_modes import checked_modes

SECTION = {"EA": 1e5, "EI": 10.0, "GJ": 8.0, "mass_per_length": 1.3, "radius": 0.02}
PARENTS = [-1, 0, 1, 2, 3, 2, 5, 6]


def tree_line():
    rng = np.random.default_rng(0)
    points = np.zeros((8, 3))
    for station in range(1, 8):
        points[station] = points[PARENTS[station]] + rng.standard_normal(3)
    return beam_line(points, parents=PARENTS, **SECTION)


@pytest.mark.parametrize(
    ("support", "n_rigid"),
    [(CLAMPED, 0), (hinged((0, 1, 1)), 1), (sliding((1, 0, 0)), 1), (BALL, 3), (FREE, 6)],
)
@pytest.mark.parametrize("make", [lambda: beam_line(straight(2.0, 40), **SECTION), tree_line])
def test_modes_are_orthonormal_on_any_support_and_any_tree(make, support, n_rigid):
    modes = intrinsic_modes(make(), support)
    assert modes.n_rigid == n_rigid
    assert np.all(modes.omega[:n_rigid] == 0)
    assert np.all(modes.omega[n_rigid:] > 0.1)
    assert max(modes.orthonormality) <= 1e-11


def test_rigid_modes_are_rigid_motions_of_the_roots_freedom():
    line = tree_line()
    modes = intrinsic_modes(line, BALL)
    rigid = modes.velocities[..., :3].reshape(-1, 3)
    assert np.linalg.lstsq(line.twists[:, 3:], rigid, rcond=None)[1] == pytest.approx(0, abs=1e-24)


def test_the_direction_of_a_line_in_space_does_not_matter():
    along_x = intrinsic_modes(beam_line(straight(2.0, 10), **SECTION), CLAMPED, 12)
    for direction in ((0, 0, 1.0), (0, 1.0, 0), (0.6, -0.64, 0.48)):
        turned = intrinsic_modes(beam_line(straight(2.0, 10, direction), **SECTION), CLAMPED, 12)
        assert turned.omega == pytest.approx(along_x.omega, rel=1e-9)


def test_freedoms_without_mass_follow_the_others():
    heavy = beam_line(straight(2.0, 10), **SECTION | {"radius": 1e-3})
    massless = beam_line(straight(2.0, 10), **SECTION | {"radius": 0.0})
    modes = intrinsic_modes(massless, CLAMPED)
    assert modes.n_modes == 30
    assert modes.omega[:6] == pytest.approx(intrinsic_modes(heavy, CLAMPED).omega[:6], rel=1e-4)
    assert max(modes.orthonormality) <= 1e-11


# [Wang2015] (38)-(41), a cantilever of length L: roots of cos x cosh x = -1.
BENDING_ROOTS = np.array([1.87510406871, 4.69409113297, 7.85475743824])


def analytic_bending(number, x, xm, L, EI, m):
    """V and W at x, F and M at xm of a mode."""
    lam = BENDING_ROOTS[number] / L
    a = lam * L
    Lam = (np.cos(a) + np.cosh(a)) / (np.sin(a) + np.sinh(a))
    s, c = lam * x, lam * xm
    V = (np.cos(s) - np.cosh(s) - Lam * (np.sin(s) - np.sinh(s))) / np.sqrt(m * L)
    W = lam * (np.sin(s) + np.sinh(s) + Lam * (np.cos(s) - np.cosh(s))) / np.sqrt(m * L)
    F = lam * np.sqrt(EI / L) * (np.sin(c) - np.sinh(c) + Lam * (np.cos(c) + np.cosh(c)))
    M = np.sqrt(EI / L) * (-np.cos(c) - np.cosh(c) + Lam * (np.sin(c) + np.sinh(c)))
    return V, W, F, M, lam**2 * np.sqrt(EI / m)


def bending_errors(n, number):
    L, EI, m = 2.0, 10.0, 1.3
    line = beam_line(
        straight(L, n), EA=1e5, EI=(25.0, EI), GJ=8.0, mass_per_length=m, orientation=(0.0, 1.0, 0.0)
    )
    modes = intrinsic_modes(line, CLAMPED, 14)
    tree = line.tree
    j = np.flatnonzero(np.abs(modes.velocities[-1, 2]) > 0.1 * np.abs(modes.velocities[-1]).sum(axis=0))[
        number
    ]
    V, W, F, M, omega = analytic_bending(number, tree.points[:, 0], tree.middles[:, 0], L, EI, m)
    sign = np.sign(V[-1] * modes.velocities[-1, 2, j])
    ours = (
        modes.velocities[:, 2, j],
        modes.velocities[:, 4, j],
        modes.forces[:, 2, j],
        modes.forces[:, 4, j],
    )
    errors = [
        np.linalg.norm(sign * a - b) / np.linalg.norm(b) for a, b in zip(ours, (V, W, F, M), strict=True)
    ]
    return np.array([*errors, abs(modes.omega[j] / omega - 1)])


@pytest.mark.parametrize("number", [0, 1, 2])
def test_bending_modes_are_the_analytic_ones_signs_included_to_second_order(number):
    coarse, fine = bending_errors(20, number), bending_errors(40, number)
    assert np.all(fine < 4e-3 * (number + 1) ** 2)
    assert np.all(np.log2(coarse / fine) > 1.8)


def test_axial_modes_are_the_analytic_ones_signs_included():
    L, EA, m, n = 2.0, 1e3, 1.3, 40
    line = beam_line(straight(L, n), EA=EA, EI=1e5, GJ=1e5, mass_per_length=m)
    modes = intrinsic_modes(line, CLAMPED, 3)
    for number, j in enumerate(range(3)):
        lam = (2 * number + 1) * np.pi / (2 * L)
        V = np.sqrt(2 / (m * L)) * np.sin(lam * line.tree.points[:, 0])
        F = -np.sqrt(2 * EA / L) * np.cos(lam * line.tree.middles[:, 0])
        sign = np.sign(V[-1] * modes.velocities[-1, 0, j])
        assert modes.omega[j] == pytest.approx(lam * np.sqrt(EA / m), rel=2e-3)
        assert sign * modes.velocities[:, 0, j] == pytest.approx(V, abs=2e-3 * np.abs(V).max())
        assert sign * modes.forces[:, 0, j] == pytest.approx(F, abs=3e-3 * np.abs(F).max())


def test_modes_that_there_are_not_are_refused():
    line = beam_line(straight(2.0, 3), **SECTION)
    for number in (5, 100):
        with pytest.raises(ModelError, match=f"{number} modes requested; it has 24 with mass, of which 6"):
            intrinsic_modes(line, FREE, number)
    with pytest.raises(ModelError, match="of which 6 are rigid"):
        intrinsic_modes(line, FREE).truncated(5)


def test_truncated_modes_are_the_lowest_ones():
    line = beam_line(straight(2.0, 5), **SECTION)
    some, every = intrinsic_modes(line, FREE, 12), intrinsic_modes(line, FREE)
    assert every.truncated(12).omega == pytest.approx(some.omega, rel=1e-12)
    assert every.truncated(12).forces.shape == (5, 6, 6)


def test_a_root_that_moves_without_mass_is_refused():
    line = beam_line(straight(2.0, 4), **SECTION | {"radius": 0.0})
    with pytest.raises(ModelError, match="moves no mass"):
        intrinsic_modes(line, hinged((1, 0, 0)))


def test_a_station_that_hangs_loose_is_refused():
    line = beam_line(straight(2.0, 4), **SECTION)
    loose = line.stiffness.copy()
    loose[24:], loose[:, 24:] = 0, 0
    loose[18:24, 18:24] -= line.stiffness[18:24, 18:24] / 2
    with pytest.raises(ModelError):
        intrinsic_modes(condensed_line("loose", line.tree.points, loose, line.mass), CLAMPED)


def test_stations_that_rotate_freely_are_refused():
    """Without any torsional stiffness a diagonal of the stiffness is zero."""
    line = beam_line(straight(2.0, 4), **SECTION)
    free = line.stiffness.copy()
    free[3::6], free[:, 3::6] = 0, 0
    with pytest.raises(ModelError, match="have no stiffness"):
        intrinsic_modes(condensed_line("free", line.tree.points, free, line.mass), CLAMPED)


@pytest.mark.parametrize("broken", ["velocities", "strains"])
def test_modes_that_are_not_orthonormal_are_refused(broken):
    modes = intrinsic_modes(tree_line(), CLAMPED, 4)
    spoiled = replace(modes, **{broken: 1.001 * getattr(modes, broken)})
    with pytest.raises(AccuracyError, match=r"its modes are orthonormal only to .* \(velocities\)"):
        checked_modes(spoiled)
