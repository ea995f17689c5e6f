"""Ties of decks: every card obeys rigid motions, and holds what it says it holds."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ImportFormatError

GRIDS = """\
CORD2R,3,,0.,0.,0.,0.,1.,1.
,1.,1.,0.
GRID,1,,0.,0.,0.
GRID,2,,2.,1.,0.
GRID,3,,0.,3.,0.,3
GRID,4,,1.,2.,3.
GRID,5,,-1.,2.,1.
"""
# Beams, so that all grids can turn.
FRAME = (
    GRIDS + "CBAR,91,9,1,2,0.,0.,1.\nCBAR,92,9,3,4,1.,0.,0.\nCBAR,93,9,5,4,0.,1.,0.\nPBAR,9,8,1.,1.,1.,1.\n"
)
FRAME += "MAT1,8,1.,,.3\n"


def constraint_matrix(read):
    """(rows, 6 n)."""
    if not read.constraints:
        return np.zeros((0, 6 * len(read.nodes)))
    (terms,) = read.constraints
    G = np.zeros((len(terms.lines), 6 * len(read.nodes)))
    G[terms.rows, terms.freedoms] = terms.factors
    return G


def rigid_modes(nodes):
    modes = np.zeros((len(nodes), 6, 6))
    modes[:, :3, :3] = modes[:, 3:, 3:] = np.eye(3)
    for i in range(3):
        modes[:, :3, 3 + i] = np.cross(np.eye(3)[i], nodes)
    return modes.reshape(-1, 6)


@pytest.mark.parametrize(
    ("card", "rows"),
    [
        ("RBE2,9,1,12,3,4", 4),
        ("RBE2,9,1,156,3,4,5", 9),
        ("RBAR,9,1,3,1235,46,46,1235", 6),
        ("RBAR,9,1,3,123,456", 6),
        ("RBAR1,9,1,3,135", 3),
        ("RROD,9,1,3,1", 1),
        ("RTRPLT,9,1,3,4,1235,34\n,,5,12346", 6),
        ("RTRPLT,9,1,4,5,123,13,3\n,46,2", 3),
        ("RBE1,9,1,123,3,13,4,3\n,UM,5,123,4,12", 5),
        ("RBE3,9,,1,123456,1.,123456,3,4\n,2.,12,5", 6),
        ("RBE3,9,,3,126,1.,123,1,4\n,5", 3),
    ],
)
def test_rigid_motions_obey(deck, card, rows):
    read = deck(FRAME + card + "\n")
    G = constraint_matrix(read)
    np.testing.assert_allclose(G @ rigid_modes(read.nodes), 0, atol=1e-12)
    assert np.linalg.matrix_rank(G) == len(G)
    assert len(G) == rows
    assert not read.left_out


def test_ties_in_all_components(deck):
    """RBE2, RBAR, RTRPLT and RBE1 of six components; of nodes that cannot turn three are all."""
    read = deck(
        FRAME + "RBE2,9,1,123456,3,4,-0.\nRBAR,10,2,5,123456\nRBAR,11,2,5,,123456\nRTRPLT,12,1,3,5,123456\n"
    )
    ties = {tie.name: (tie.reference, tie.nodes.tolist()) for tie in read.rigid}
    assert ties == {
        "rbe2_9": (0, [2, 3]),
        "rbar_10": (1, [4]),
        "rbar_11": (4, [1]),
        "rtrplt_12": (0, [2, 4]),
    }
    assert not read.constraints
    np.testing.assert_array_equal(read.node_sets["rbe2_9"], [2, 3])
    solids = deck(GRIDS + "CTETRA,1,7,1,2,3,4\nPSOLID,7,8\nMAT1,8,1.,,.3\nRBE2,9,5,123,1,THRU,4\n")
    assert solids.rigid[0].nodes.tolist() == [0, 1, 2, 3]
    ranged = deck(FRAME + "RBE2,9,1,123456,2,THRU,4,5,1.-5\n,20.\n")
    assert ranged.rigid[0].nodes.tolist() == [1, 2, 3, 4]


@pytest.mark.parametrize(
    "more",
    [
        "CONM2,5,5,,1.\n,2.,,2.,,,2.\n",
        "CELAS2,5,3.,5,4\n",
        "CBUSH,5,6,5,1,,,,0\nPBUSH,6,K,,,,1.\n",
        "CMASS2,5,3.,5,6\n",
        "MPC,1,5,4,1.,4,5,1.\n",
        "RBE2,10,5,123456,3\n",
        "RBE2,10,3,123456,5\n",
        "RBE3,10,,5,456,1.,123,2,3\n,4\n",
        "RBAR,10,5,3,123456\n",
    ],
)
def test_a_tie_of_translations_leaves_rotations_that_something_acts_on(deck, more):
    """A ball at grid 5, as by three constraints; where nothing acts on its rotations the tie is rigid."""
    solid = GRIDS + "CTETRA,1,7,1,2,3,4\nPSOLID,7,8\nMAT1,8,1.,,.3\n"
    tie = "RBE2,9,1,123,5\n"
    assert [each.name for each in deck(solid + tie).rigid] == ["rbe2_9"]
    assert [each.name for each in deck(solid + tie + "SPC1,1,456,5\n").rigid] == ["rbe2_9"]
    assert not deck(solid + tie + "SPC1,1,456,5\n").held
    read = deck(solid + tie + more)
    assert "rbe2_9" not in [each.name for each in read.rigid]
    rows = constraint_matrix(read)
    balls = rows[np.abs(rows[:, 24:27]).sum(axis=1) > 0]
    np.testing.assert_allclose(balls[:3, 24:27], np.eye(3))
    np.testing.assert_allclose(balls[:3] @ rigid_modes(read.nodes), 0, atol=1e-12)


def test_weighted_means(deck):
    """A mean of translations; weights of a grid named twice add up; UM changes no equation."""
    read = deck(FRAME + "RBE3,9,,1,123,1.,123,3,4\n,2.5,123,4,5,UM,3\n,1\n")
    (mean,) = read.means
    assert mean.reference == 0
    assert dict(zip(mean.nodes.tolist(), mean.weights.tolist(), strict=True)) == {2: 1.0, 3: 3.5, 4: 2.5}
    assert mean.components == (True, True, True, False, False, False)
    np.testing.assert_array_equal(read.node_sets["rbe3_9"], [2, 3, 4])


def test_a_mean_with_rotations_has_least_squares(deck):
    """Grids that only turn, all alike: the reference turns as they do, and moves with their centre."""
    read = deck(FRAME + "RBE3,9,,1,123456,1.,123456,2,3\n,4\n")
    G = constraint_matrix(read)
    modes = rigid_modes(read.nodes)
    u = modes @ [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    noise = np.random.default_rng(0).normal(size=u.shape)
    noise[:6] = noise[24:] = 0  # the reference, and what is not averaged
    u += noise
    # Solve for the reference, and compare with weighted least squares of numpy.
    reference = np.linalg.solve(G[:, :6], -G[:, 6:] @ u[6:])
    L = np.linalg.norm(read.nodes[1:4] - read.nodes[0], axis=1).mean()
    weights = np.tile([1, 1, 1, L, L, L], 3)
    picked = np.arange(6, 24)
    about = rigid_modes(read.nodes - read.nodes[0])[picked]
    expected = np.linalg.lstsq(about * weights[:, None], u[picked] * weights, rcond=None)[0]
    np.testing.assert_allclose(reference, expected, atol=1e-12)


def test_sums_of_freedoms(deck):
    """MPC of the chosen set, over several rows, with local axes and scalar points; MPCADD joins sets."""
    cards = "SPOINT,77\nMPC,5,1,2,2.,2,1,-3.\n,,4,6,.5,77,0,4.\nMPC,6,3,1,1.,1,1,-1.\n"
    cards += "MPC,7,1,1,1.\nMPCADD,8,5,6\n"
    read = deck("SOL 101\nCEND\nMPC = 8\nBEGIN BULK\n" + FRAME + cards + "ENDDATA\n")
    (terms,) = read.constraints
    n = len(read.nodes)
    first = {f: v for f, v, r in zip(terms.freedoms, terms.factors, terms.rows, strict=True) if r == 0}
    assert first == {1: 2.0, 6: -3.0, 23: 0.5, 6 * n: 4.0}
    assert terms.dependent.tolist()[0] == 1
    assert len(terms.lines) == 2
    # The x axis of system 3 lies in the plane of (0, 1, 1) and (1, 1, 0): (2, 1, -1) / sqrt(6).
    second = {f: v for f, v, r in zip(terms.freedoms, terms.factors, terms.rows, strict=True) if r == 1}
    axis = np.array([2, 1, -1]) / np.sqrt(6)
    assert [second[12], second[13], second[14], second[0]] == pytest.approx([*axis, -1.0])
    assert deck(FRAME + cards.replace("MPC,6", "MPC,5").replace("MPC,7", "MPC,5")).constraints
    unchosen = deck(FRAME + cards)
    assert not unchosen.constraints
    assert any("MPC sets 5, 6, 7 are not applied" in note for note in unchosen.notes)


@pytest.mark.parametrize(
    ("card", "meaning"),
    [
        ("RBE2,9,1,123456", "ties no grids"),
        ("RBAR,9,1,3,123", "do not determine a rigid motion"),
        ("RBE1,9,1,123456", "no independent, or no dependent"),
        ("RTRPLT,9,1,3,4", "no independent, or no dependent"),
        ("RBE3,9,,1,123456,1.,123456", "averages no grids"),
        ("RBE3,9,,1,123456,1.,12,2,3", "the components it averages do not determine"),
        ("RSPLINE,9,.1,1,2", "an interpolation between grids"),
    ],
)
def test_ties_that_are_left_out(deck, card, meaning):
    (left,) = deck(FRAME + card + "\n").left_out
    assert meaning in left.meaning


@pytest.mark.parametrize(
    ("card", "message"),
    [
        ("RBE2,9,1,127,3", "line 13: RBE2: its components are '127', not some of 123456"),
        ("RBE2,9,1,123456,99", "line 13: RBE2: names grid 99"),
        ("RBE2,9,1,123456,3\nRBE2,9,1,123456,4", "line 14: RBE2: element 9 is defined a second time"),
        ("RBE3,9,,1,123456,10,3", "line 13: RBE3: '10' stands where a weight is expected"),
        ("RBE3,9,,1,,1.,123,3", "line 13: RBE3: the components of its reference grid are ''"),
        ("RROD,9,1,1,1", "line 13: RROD: its two grids coincide"),
        ("RBE1,9,1,129", "line 13: RBE1: the components of grid 1 are '129'"),
    ],
)
def test_what_is_wrong_with_ties(deck, card, message):
    with pytest.raises(ImportFormatError, match=message):
        deck(FRAME + card + "\n")
