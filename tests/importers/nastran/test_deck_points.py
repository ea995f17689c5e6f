"""Springs, dampers and masses of decks: their forces, by closed forms, and one card against another."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ImportFormatError
from supple.importers.deck import NodalMatrix

GRIDS = """\
CORD2R,3,,0.,0.,0.,0.,0.,1.
,0.,1.,0.
GRID,1,,0.,0.,0.
GRID,2,,2.,1.,0.
GRID,3,,0.,0.,0.,3
GRID,4,,1.,2.,3.
"""


def matrix(terms, n):
    """Matrix (6 n, 6 n) of terms with values: sum of k s s^T."""
    K = np.zeros((6 * n, 6 * n))
    for each in terms:
        for row, value in enumerate(each.values):
            picked = each.rows == row
            s = np.zeros(6 * n)
            s[each.freedoms[picked]] = each.factors[picked]
            K += value * np.outer(s, s)
    return K


def masses(read):
    M = np.zeros((6 * len(read.nodes), 6 * len(read.nodes)))
    for each in read.masses:
        M[np.ix_(each.freedoms, each.freedoms)] += each.values
    return M


def rigid_modes(nodes):
    """Rigid motions (6 n, 6) about the origin."""
    modes = np.zeros((len(nodes), 6, 6))
    modes[:, :3, :3] = modes[:, 3:, 3:] = np.eye(3)
    for i in range(3):
        modes[:, :3, 3 + i] = np.cross(np.eye(3)[i], nodes)
    return modes.reshape(-1, 6)


# --- between components


@pytest.mark.parametrize(
    ("spring", "field"),
    [("CELAS", "springs"), ("CDAMP", "dashpots"), ("CMASS", "inertias")],
)
def test_scalar_elements_of_all_forms(deck, spring, field):
    """By property or value, between components or scalar points, or to ground."""
    prop = {"CELAS": "PELAS,7,5.,,,8,6.", "CDAMP": "PDAMP,7,5.,8,6.", "CMASS": "PMASS,7,5.,8,6."}[spring]
    text = (
        GRIDS
        + f"{prop}\n{spring}1,1,8,1,3,2,3\n{spring}2,2,4.,3,1\n{spring}3,3,7,101,102\n{spring}4,4,3.,101\n"
    )
    read = deck(text)
    np.testing.assert_array_equal(read.scalar_points, [101, 102])
    n = len(read.nodes)
    K = matrix(getattr(read, field), n + 2)
    expected = np.zeros_like(K)
    z1, z2, a, b = 2, 6 + 2, 6 * n, 6 * (n + 1)
    expected[np.ix_([z1, z2], [z1, z2])] += 6.0 * np.array([[1, -1], [-1, 1]])
    expected[2 * 6 + 1, 2 * 6 + 1] += 4.0  # x of grid 3 is the basic y
    expected[np.ix_([a, b], [a, b])] += 5.0 * np.array([[1, -1], [-1, 1]])
    expected[a, a] += 3.0
    np.testing.assert_allclose(K, expected, atol=1e-12)


def test_grids_that_scalar_elements_name_stay_grids(deck):
    read = deck(GRIDS + "CELAS4,1,3.,2\n")
    assert not read.scalar_points.size
    assert read.springs[0].freedoms.tolist() == [6]


# --- bushings


def test_a_bushing_costs_nothing_in_rigid_motion_and_its_value_along_each_axis(deck):
    read = deck(GRIDS + "CBUSH,1,7,1,2,0.,0.,1.\nPBUSH,7,K,1.,2.,3.,4.,5.,6.\n,,B,.1\n")
    K = matrix(read.springs, len(read.nodes))
    np.testing.assert_allclose(K @ rigid_modes(read.nodes), 0, atol=1e-12)
    x = np.array([2, 1, 0]) / np.sqrt(5)
    y, z = np.array([0, 0, 1.0]), np.cross(x, [0, 0, 1.0])
    for k, axis in zip((1.0, 2.0, 3.0), (x, y, z), strict=True):
        u = np.zeros(K.shape[0])
        u[6:9] = axis
        assert u @ K @ u == pytest.approx(k)
    for k, axis in zip((4.0, 5.0, 6.0), (x, y, z), strict=True):
        u = np.zeros(K.shape[0])
        u[9:12] = axis
        # The springs stand midway, and the half arm of grid 2 moves them across.
        across = np.cross(axis, -(read.nodes[1] - read.nodes[0]) / 2)
        expected = k + 2.0 * (across @ y) ** 2 + 3.0 * (across @ z) ** 2
        assert u @ K @ u == pytest.approx(expected)
    C = matrix(read.dashpots, len(read.nodes))
    assert C[:3, :3] == pytest.approx(0.1 * np.outer(x, x))


def test_a_bushing_at_one_place_has_the_axes_of_its_system(deck):
    """CID 3 has its x along the basic y; without GB it holds to ground; S places it; OCID, too."""
    read = deck(GRIDS + "CBUSH,1,7,1,3,,,,3\nPBUSH,7,K,1.,2.,3.\n")
    K = matrix(read.springs, len(read.nodes))
    np.testing.assert_allclose(np.diag(K)[:3], [2, 1, 3])
    held = matrix(deck(GRIDS + "CBUSH,1,7,1,,,,,3\nPBUSH,7,K,1.,2.,3.\n").springs, len(read.nodes))
    np.testing.assert_allclose(held[:3, :3], np.diag([2.0, 1, 3]))
    assert not held[6:, 6:].any()
    by_ratio = deck(GRIDS + "CBUSH,1,7,1,2,,,,0\n,.25\nPBUSH,7,K,1.,2.,3.\n")
    by_place = deck(GRIDS + "CBUSH,1,7,1,2,,,,0\n,,0,.5,.25,0.\nPBUSH,7,K,1.,2.,3.\n")
    np.testing.assert_allclose(*(matrix(each.springs, len(read.nodes)) for each in (by_ratio, by_place)))


def test_a_bushing_along_a_line_is_a_spring_and_a_damper(deck):
    along = deck(GRIDS + "CBUSH1D,1,7,1,2\nPBUSH1D,7,5.,.5,8.\n")
    bush = deck(GRIDS + "CBUSH,1,7,1,2,0.,0.,1.\nPBUSH,7,K,5.\n,,B,.5\n,,M,8.\n")
    n = len(along.nodes)
    for field in ("springs", "dashpots"):
        np.testing.assert_allclose(*(matrix(getattr(each, field), n) for each in (along, bush)), atol=1e-12)
    np.testing.assert_allclose(masses(along), masses(bush))
    assert np.trace(masses(along)) == pytest.approx(3 * 8.0)


def test_a_viscous_damper(deck):
    read = deck(GRIDS + "CVISC,1,7,1,2\nPVISC,7,2.,3.\n")
    C = matrix(read.dashpots, len(read.nodes))
    x = np.array([2, 1, 0]) / np.sqrt(5)
    np.testing.assert_allclose(C[:3, :3], 2 * np.outer(x, x))
    np.testing.assert_allclose(C[3:6, 9:12], -3 * np.outer(x, x))


def test_a_rigid_direction_of_a_bushing_has_no_stiffness_and_the_others_have_theirs(deck):
    read = deck(GRIDS + "CBUSH,1,7,1,2,0.,0.,1.\nPBUSH,7,K,RIGID,2.,,,RIGID,6.\n,,B,1.\n")
    same = deck(GRIDS + "CBUSH,1,7,1,2,0.,0.,1.\nPBUSH,7,K,,2.,,,,6.\n,,B,1.\n")
    for field in ("springs", "dashpots"):
        np.testing.assert_array_equal(*(matrix(getattr(each, field), 4) for each in (read, same)))
    (left,) = read.left_out
    assert "rigid directions of a CBUSH (K = RIGID) are not read" in left.meaning


def test_a_group_of_a_bushing_in_the_wrong_field_is_left_out(deck):
    (left,) = deck(GRIDS + "CBUSH,1,7,1,2,0.,0.,1.\nPBUSH,7,K,5.\n,B,1.\n").left_out
    assert left.card == "PBUSH"
    assert "without its K, B or M in the third field" in left.meaning


# --- masses


def test_a_mass_beside_its_grid(deck):
    """Kinetic energy of a rigid body: m v^2 / 2 of its centre, w I w / 2 about it."""
    text = "CONM2,1,4,0,2.,.1,.2,.3\n,5.,.5,6.,.25,.125,7.\n"
    read = deck(GRIDS + text)
    M = masses(read)
    v, w, d = np.array([1.0, -2, 3]), np.array([0.3, 0.2, -0.1]), np.array([0.1, 0.2, 0.3])
    u = np.zeros(M.shape[0])
    u[18:21], u[21:24] = v, w
    inertia = np.array([[5, -0.5, -0.25], [-0.5, 6, -0.125], [-0.25, -0.125, 7]])
    centre = v + np.cross(w, d)
    assert u @ M @ u == pytest.approx(2 * centre @ centre + w @ inertia @ w)


def test_a_mass_in_axes_of_its_own(deck):
    """CID 3: x is the basic y, y the basic -x; CID -1 gives the place of the centre; PARAM scales."""
    turned = deck(GRIDS + "CONM2,1,4,3,2.,.1,.2,.3\n,5.,,6.,,,7.\n")
    plain = deck(GRIDS + "CONM2,1,4,,2.,-.2,.1,.3\n,6.,,5.,,,7.\n")
    placed = deck(GRIDS + "CONM2,1,4,-1,2.,.8,2.1,3.3\n,6.,,5.,,,7.\n")
    half = deck(GRIDS + "PARAM,WTMASS,.5\nCONM2,1,4,,4.,-.2,.1,.3\n,12.,,10.,,,14.\n")
    for each in (turned, placed, half):
        np.testing.assert_allclose(masses(each), masses(plain), atol=1e-12)


def test_a_mass_by_its_matrix(deck):
    full = deck(GRIDS + "CONM2,1,4,3,2.,.1,.2,.3\n,5.,,6.,,,7.\n")
    m, d = 2.0, np.array([0.1, 0.2, 0.3])
    x = np.array([[0, -d[2], d[1]], [d[2], 0, -d[0]], [-d[1], d[0], 0]])
    M = np.block([[m * np.eye(3), -m * x], [m * x, np.diag([5.0, 6, 7]) - m * x @ x]])
    words = [f"{value:.6f}" for value in M[np.tril_indices(6)]]
    rows = ["CONM1,1,4,3," + ",".join(words[:5])] + [
        "," + ",".join(words[i : i + 8]) for i in range(5, len(words), 8)
    ]
    np.testing.assert_allclose(masses(deck(GRIDS + "\n".join(rows) + "\n")), masses(full), atol=1e-12)


def test_a_point_mass_asks_for_no_rotation(deck):
    (only,) = deck(GRIDS + "CONM2,1,4,,2.\n").masses
    assert isinstance(only, NodalMatrix)
    np.testing.assert_array_equal(only.freedoms, [18, 19, 20])


# --- shear panels


PANEL = "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\nGRID,3,,{lean},1.,0.\nGRID,4,,{top},1.,0.\nMAT1,5,2.6,,.3,100.\n"


def test_a_shear_panel(deck):
    """Of a rectangle: energy G t A gamma^2 / 2 in shear, none stretched or turned; its mass in its grids."""
    text = PANEL.format(lean="2.", top="0.") + "CSHEAR,1,7,1,2,3,4\nPSHEAR,7,5,.1,3.\n"
    read = deck(text)
    K = matrix(read.springs, 4)
    np.testing.assert_allclose(K @ rigid_modes(read.nodes), 0, atol=1e-12)
    sheared, stretched = np.zeros((4, 6)), np.zeros((4, 6))
    sheared[:, 0] = 0.01 * read.nodes[:, 1]
    stretched[:, 0] = 0.01 * read.nodes[:, 0]
    assert sheared.ravel() @ K @ sheared.ravel() == pytest.approx(1.0 * 0.1 * 2.0 * 0.01**2)
    assert np.abs(K @ stretched.ravel()).max() < 1e-15
    M = masses(read)
    assert np.trace(M) == pytest.approx(3 * 2.0 * (100 * 0.1 + 3))


def test_a_leaning_shear_panel_is_softer(deck):
    """A parallelogram by Garvey: 1 + 2 tan^2 / (1 + nu) times the compliance; its sides do not stretch."""
    G, t, tan = 1.0, 0.1, 0.5
    read = deck(PANEL.format(lean="2.5", top=".5") + "CSHEAR,1,7,1,2,3,4\nPSHEAR,7,5,.1\n")
    (terms,) = read.springs
    assert 1 / terms.values[0] == pytest.approx(2.0 / (G * t) * (1 + 2 * tan**2 / 1.3))
    # A shear along the lower side moves the upper one by d: the forces q L do the work q L d.
    u = np.zeros((4, 6))
    u[2:, 0] = 0.01
    work = terms.factors @ u.ravel()[terms.freedoms]
    assert abs(work) == pytest.approx(2.0 * 0.01)


# --- non-structural mass


SHELLS = """\
GRID,1,,0.,0.,0.
GRID,2,,2.,0.,0.
GRID,3,,2.,1.,0.
GRID,4,,0.,1.,0.
CQUAD4,1,9,1,2,3,4
CTRIA3,2,8,1,2,3
CROD,3,7,1,2
PSHELL,9,5,.1,5,,5
PSHELL,8,5,.1,5,,5
PROD,7,5,1.
MAT1,5,1.,,.3,10.
"""


@pytest.mark.parametrize(
    ("cards", "quad", "triangle", "rod"),
    [
        ("NSM,6,PSHELL,9,.5,8,.25", 0.5, 0.25, 0),
        ("NSM1,6,PSHELL,.5,ALL", 0.5, 0.5, 0),
        ("NSM1,6,PCOMP,.5,ALL", 0, 0, 0),
        ("NSM1,6,ELEMENT,.5,1,THRU,3", 0.5, 0.5, 0.5),
        ("NSM1,6,PROD,.5,7", 0, 0, 0.5),
        ("NSML,6,PSHELL,9,3.", 1.5, 0, 0),
        ("NSML1,6,PSHELL,3.,8,9", 1.0, 1.0, 0),
        ("NSML1,6,PROD,3.,7", 0, 0, 1.5),
        ("NSM1,16,PROD,.5,7\nNSM1,17,PSHELL,.25,9\nNSMADD,6,16,17", 0.25, 0, 0.5),
        ("NSM1,7,PSHELL,.5,ALL", 0, 0, 0),
    ],
)
def test_added_mass(deck, cards, quad, triangle, rod):
    """Per area or length, or a total spread over all; where case control chooses the set."""
    read = deck("SOL 103\nCEND\nNSM = 6\nBEGIN BULK\n" + SHELLS + cards + "\nENDDATA\n")
    made = {found.name: read.properties[found.property] for found in read.elements}
    assert made["CQUAD4"].added_mass == pytest.approx(quad)
    assert made["CTRIA3"].added_mass == pytest.approx(triangle)
    assert made["CROD"].mass_per_length == pytest.approx(10 + rod)


def test_added_mass_of_bars_with_default_properties(deck):
    """A blank property of a CBAR is that of BAROR."""
    bars = "BAROR,,6,,,0.,0.,1.\nCBAR,4,,1,2\nPBAR,6,5,1.,1.,1.,1.\nNSM1,6,PBAR,.5,6\n"
    read = deck("SOL 103\nCEND\nNSM = 6\nBEGIN BULK\n" + SHELLS + bars + "ENDDATA\n")
    assert read.properties["pbar_6"].first.mass_per_length == pytest.approx(10 + 0.5)


def test_added_mass_that_is_left_out(deck):
    read = deck("SOL 103\nCEND\nNSM = 6\nBEGIN BULK\n" + SHELLS + "NSM1,6,PGAP,1.,ALL\nENDDATA\n")
    assert read.left_out[0].meaning == "left out: mass of PGAP is not read"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("CELAS2,1,4.,99,1\n", "line 7: CELAS2: names grid 99"),
        ("CELAS2,1,4.,1,7\n", "line 7: CELAS2: component 7 of grid 1; give 1 to 6"),
        ("CVISC,1,7,1,3\nPVISC,7,2.\n", "line 7: CVISC: its two grids coincide.*use CDAMP"),
        ("CBUSH1D,1,7,1,3\nPBUSH1D,7,2.\n", "line 7: CBUSH1D: its two grids coincide.*give CID"),
        *(
            (f"{name},7,1.,,,\n{name},8,1.\n{name},7,2.\n", f"line 9: {name}: property 7 is defined a second")
            for name in ("PELAS", "PDAMP", "PMASS", "PVISC")
        ),
        ("PELAS,7,1.,,,7,2.\n", "line 7: PELAS: property 7 is defined a second time"),
        ("CONM2,1,4,8,2.\n", "line 7: CONM2: names coordinate system 8"),
        ("CSHEAR,1,7,1,1,3,3\nPSHEAR,7,5,.1\nMAT1,5,1.,,.3\n", "line 7: CSHEAR: its area, thickness"),
    ],
)
def test_what_is_wrong_with_points(deck, text, message):
    with pytest.raises(ImportFormatError, match=message):
        deck(GRIDS + text)


def test_points_without_property_are_left_out(deck):
    text = "CELAS1,1,7,1,1\nCBUSH,2,7,1,2\nCBUSH1D,3,7,1,2\nCVISC,4,7,1,2\nCSHEAR,5,7,1,2,3,4\n"
    left = deck(GRIDS + text).left_out
    assert [each.card for each in left] == ["CELAS1", "CVISC", "CBUSH", "CBUSH1D", "CSHEAR"]
    rigid = deck(GRIDS + "CBUSH,2,7,1,2\nPBUSH,7,K,RIGID\n").left_out
    assert "rigid directions" in rigid[0].meaning
