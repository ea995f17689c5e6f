"""Bodies of superelements: merged they are the whole deck; moved or mirrored they keep their frequencies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.body import deck_frequencies, deck_mass, deck_model, flexible_body
from supple.errors import SuppleWarning
from supple.importers import read_deck
from supple.importers.moved_deck import moved_deck
from supple.machine import split_body
from supple.machine.split_body import frequency_changes
from supple.mesh import ByCellSets, cuts_at_nodes

# One of everything that has axes: laminates out of balance, with offsets; beams with I12, offsets, pins and
# neutral axis apart; anisotropic solids; springs, masses and constraints in turned axes.
EVERYTHING = """\
CORD2R,9,,0.,0.,0.,.3,.2,1.
,1.,.1,.2
GRID,1,,0.,0.,0.
GRID,2,,1.,.1,0.
GRID,3,,1.1,1.,.2
GRID,4,,0.,.9,.1
GRID,5,,.1,.1,1.,9
GRID,6,,1.2,0.,1.1,9
GRID,7,,1.,1.,1.,9
GRID,8,,-.1,1.,1.
GRID,9,,2.,.2,.1,9
GRID,10,,2.5,.7,.3
GRID,11,,.4,.5,1.6
CHEXA,1,1,1,2,3,4,5,6
,7,8
PSOLID,1,1,9
MAT9,1,3.+11,1.+11,.9+11,.1+11,.0,.2+11,2.+11
,.8+11,.0,.15+11,.0,2.5+11,.0,.1+11,.0
,.7+11,.05+11,.0,.6+11,.05+11,.9+11,7800.
CTRIA3,2,2,2,9,3,30.
CTRIA3,3,2,3,9,10,-20.
PCOMP,2,.02
,3,.01,30.,,3,.02,75.
MAT8,3,1.4+11,1.+10,.3,5.+9,5.+9,4.+9,1600.
CTRIA3,4,4,5,6,11,,.03
PSHELL,4,5,.02,5
MAT1,5,2.1+11,,.3,7850.
CBEAM,5,5,9,10,.1,.2,1.
,,5,.1,.0,.05,.0,.2,.1
PBEAM,5,5,2.-3,3.-6,5.-6,1.-6,4.-6,3.
,,,,,,,,
,,,,,,,,
,.02,.03,.01,.04,.015,-.02,.01,.03
CELAS2,6,4.+6,7,2
CONM2,7,10,9,5.,.1,.2,-.1
,.1,.02,.2,.01,.03,.3
RBE3,8,,11,123456,1.,123,7,8
,5
CDAMP2,9,1.,9,1,6,1
RBE2,10,10,123456,12
GRID,12,,3.,.5,.5
CONM2,11,12,,2.
"""


@pytest.fixture(scope="module", params=["9", ""], ids=["axes of the solid", "basic axes"])
def everything(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("deck") / "everything.bdf"
    path.write_text(EVERYTHING.replace("PSOLID,1,1,9", f"PSOLID,1,1,{request.param}"))
    deck = read_deck(path)
    assert deck.left_out == ()
    return deck


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_moved_deck_is_the_same_body(everything, mirrored):
    """Every isometry keeps frequencies, at the deck's own springs to ground; mass goes with it."""
    Q = Rotation.from_rotvec([0.7, -0.4, 1.3]).as_matrix() @ np.diag([1.0, 1.0, -1.0 if mirrored else 1.0])
    shift = np.array([1.0, -2.0, 3.0])
    moved = moved_deck(everything, Q, shift)
    here, there = deck_mass(everything), deck_mass(moved)
    assert there.mass == pytest.approx(here.mass, rel=1e-12)
    np.testing.assert_allclose(there.centre, Q @ here.centre + shift, atol=1e-12)
    np.testing.assert_allclose(there.inertia, Q @ here.inertia @ Q.T, atol=1e-9 * np.trace(here.inertia))
    wanted = deck_frequencies(everything, 12, held=True)
    np.testing.assert_allclose(deck_frequencies(moved, 12, held=True)[6:], wanted[6:], rtol=1e-9)


def test_springs_to_ground_of_a_moved_deck_are_supports(tmp_path):
    path = tmp_path / "grounded.bdf"
    path.write_text(plate((0, 1)) + "CELAS2,9,100.,2,3\n")
    Q = Rotation.from_rotvec([0.7, -0.4, 1.3]).as_matrix()
    moved = moved_deck(read_deck(path), Q, np.zeros(3))
    assert len(moved.springs[0].freedoms) == 3
    with pytest.warns(SuppleWarning, match="1 springs or dashpots to ground, first on line .* are supports"):
        assert deck_model(moved).attached.springs == ()


def plate(columns, rows=(0, 2)):
    """Square quadrilaterals of 1/8 m from column to column and row to row, with ids of their own."""
    places = [(i, j) for i in range(columns[0], columns[1] + 1) for j in range(rows[0], rows[1] + 1)]
    ids = {place: 1 + n for n, place in enumerate(places)}
    grids = [f"GRID,{n},,{i / 8},{j / 8},0." for (i, j), n in ids.items()]
    cells = [
        f"CQUAD4,{1 + 2 * (i - columns[0]) + j},7,"
        + ",".join(str(ids[i + di, j + dj]) for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)))
        for i in range(*columns)
        for j in range(*rows)
    ]
    return "\n".join([*grids, *cells, "PSHELL,7,5,.01,5", "MAT1,5,7.+10,,.3,2700.", ""])


def test_a_plate_of_two_superelements_is_the_plate(tmp_path):
    whole, parted = tmp_path / "whole.bdf", tmp_path / "parted.bdf"
    whole.write_text(plate((0, 8)) + "CONM2,99,14,,.7\n")
    parts = f"BEGIN SUPER=1\n{plate((0, 4))}CONM2,99,14,,.7\nBEGIN SUPER=2\n{plate((4, 8))}"
    parted.write_text(f"BEGIN BULK\n{parts}ENDDATA\n")
    one, two = read_deck(whole), read_deck(parted)
    assert len(two.nodes) == len(one.nodes) == 27
    mass = deck_mass(one)
    assert deck_mass(two).mass == pytest.approx(mass.mass, rel=1e-13)
    assert sum(deck_mass(part).mass for part in two.superelements.values()) == pytest.approx(mass.mass)
    frequencies = deck_frequencies(one, 12)
    np.testing.assert_allclose(deck_frequencies(two, 12), frequencies, rtol=1e-9)


def test_joints_at_every_common_grid_are_exact(tmp_path):
    """Four superelements that meet in one grid, and a residual structure that is a mass there."""
    corners = "BEGIN BULK\nGRID,500,,.5,.125,0.\nCONM2,501,500,,2.\n"
    quarters = [(i, i + 4, j, j + 1) for i in (0, 4) for j in (0, 1)]
    parts = "".join(
        f"BEGIN SUPER={n}\n{plate((i, k), rows=(j, m))}" for n, (i, k, j, m) in enumerate(quarters, start=1)
    )
    path = tmp_path / "quarters.bdf"
    path.write_text(f"{corners}{parts}ENDDATA\n")
    deck = read_deck(path)
    assert list(deck.superelements) == ["super_0", "super_1", "super_2", "super_3", "super_4"]
    model, sets = deck_model(deck), ByCellSets([f"super_{n}" for n in range(1, 5)])
    split = split_body("plate", model, sets, cuts=cuts_at_nodes)
    names = [joint.name for joint in split.joints]
    assert len(set(names)) == len(names) == 2 + 2 * 4 + 3
    assert [name for name in names if "node-500" in name] == [
        f"plate node-500 1-{second}" for second in (2, 3, 4)
    ]
    assert abs(frequency_changes(flexible_body("plate", model), split)).max() < 1e-9
