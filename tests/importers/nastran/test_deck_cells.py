"""Solids and shells of decks: cells, walls, materials; each card against a closed form or another card."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import deck_frequencies, deck_mass
from supple.errors import ImportFormatError
from supple.importers.deck import (
    AnisotropicMaterial,
    IsotropicMaterial,
    ShellProperty,
    SolidProperty,
    WallProperty,
)
from supple.mesh import CellType, Mesh, block

MATERIAL = "MAT1,5,2.1+11,,.3,7850.\n"
STEEL = IsotropicMaterial(2.1e11, 0.3, 7850.0)
SQUARE = "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\nGRID,3,,2.,1.,0.\nGRID,4,,0.,1.,0.\n"


def grids(points):
    return "".join(f"GRID,{i},,{x:.6f},{y:.6f},{z:.6f}\n" for i, (x, y, z) in enumerate(points, 1))


def card(name, number, of, ids):
    """A card in free fields, eight to a row."""
    words = [str(w) for w in (number, of, *ids)]
    rows = [words[i : i + 8] for i in range(0, len(words), 8)]
    return name + "".join(f",{','.join(row)}\n" for row in rows)


def wall(deck, text):
    (only,) = deck(SQUARE + MATERIAL + "CQUAD4,7,9,1,2,3,4\n" + text).properties.values()
    return only


# --- solids


# Corners and middles of one cell in Nastran's order: bottom, upright, top sides.
PRISM = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)], dtype=float)
PRISM_SIDES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 4), (2, 5), (3, 4), (4, 5), (5, 3)]
PYRAMID = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)], dtype=float)
PYRAMID_SIDES = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)]


@pytest.mark.parametrize(
    ("name", "corners", "sides", "kinds"),
    [
        ("CPENTA", PRISM, PRISM_SIDES, (CellType.WEDGE6, CellType.WEDGE15)),
        ("CPYRAM", PYRAMID, PYRAMID_SIDES, (CellType.PYRAMID5, CellType.PYRAMID13)),
    ],
)
def test_wedges_and_pyramids_with_and_without_middles(deck, name, corners, sides, kinds):
    """Each middle node stands where the cell's own edges want it."""
    points = np.vstack([corners, [corners[list(side)].mean(axis=0) for side in sides]])
    property_card = "PSOLID,3,5\n" + MATERIAL
    n = len(corners)
    text = grids(points) + card(name, 1, 3, range(1, len(points) + 1)) + card(name, 2, 3, range(1, n + 1))
    linear, quadratic = deck(text + property_card).elements
    assert (linear.kind, quadratic.kind) == kinds
    np.testing.assert_array_equal(linear.nodes, [np.arange(n)])
    ends = np.array(quadratic.kind.edges)
    np.testing.assert_allclose(points[quadratic.nodes[0, n:]], points[quadratic.nodes[0, ends]].mean(axis=1))


@pytest.mark.parametrize("kind", [CellType.TETRA4, CellType.TETRA10, CellType.HEXA8, CellType.HEXA20])
def test_tetrahedra_and_hexahedra(deck, bulk, kind):
    mesh = block(2.0, 1.0, 1.0, 2, 1, 1, kind)
    read = deck(bulk.text(mesh, *bulk.solid()))
    (cells,) = read.elements
    np.testing.assert_array_equal(cells.nodes, mesh.cells[kind])
    np.testing.assert_array_equal(read.nodes, mesh.nodes)
    (made,) = read.properties.values()
    assert isinstance(made, SolidProperty)
    assert made.material == STEEL


def test_a_hexahedron_bends_by_default(deck):
    """One row of 5 : 1 boxes, clamped: f = 1.8751^2 / (2 pi) sqrt(E I / (rho A L^4)) within 1 %."""
    mesh = block(10.0, 0.1, 0.1, 20, 1, 1, CellType.HEXA8)
    text = grids(mesh.nodes) + "".join(
        card("CHEXA", i + 1, 3, nodes + 1) for i, nodes in enumerate(mesh.cells[CellType.HEXA8])
    )
    held = "SPC1,1,123," + ",".join(str(i + 1) for i in mesh.nodes_of("root")) + "\n"
    text += "MAT1,5,2.1+11,,0.,7800.\n"
    head = "SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n"
    first = 1.8751041**2 / (2 * np.pi) * np.sqrt(2.1e11 * 0.01 / 12 / 7800.0) / 100
    found = deck_frequencies(deck(head + text + held + "PSOLID,3,5\n"), 1, held=True)[0]
    assert found == pytest.approx(first, rel=0.01)
    locked = deck_frequencies(deck(head + text + held + "PSOLID,3,5,,TWO,,FULL\n"), 1, held=True)[0]
    assert locked > 2 * first


TETRA = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
TETRA_SIDES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
CUBE = np.array([(*xy, z) for z in (0, 1) for xy in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)
CUBE_SIDES = [*((i, (i + 1) % 4) for i in range(4)), *((i, i + 4) for i in range(4))]
CUBE_SIDES += [(4 + i, 4 + (i + 1) % 4) for i in range(4)]


@pytest.mark.parametrize(
    ("name", "corners", "sides"),
    [
        ("CTETRA", TETRA, TETRA_SIDES),
        ("CPYRAM", PYRAMID, PYRAMID_SIDES),
        ("CPENTA", PRISM, PRISM_SIDES),
        ("CHEXA", CUBE, CUBE_SIDES),
    ],
)
def test_solids_of_either_sense_are_turned_outwards(deck, name, corners, sides):
    """Nastran takes both; in a mirror, a solid is of the other one."""
    points = np.vstack([corners, [corners[list(side)].mean(axis=0) for side in sides]])
    text = card(name, 1, 3, range(1, len(points) + 1)) + "PSOLID,3,5\n" + MATERIAL
    for own in (points, points * [1, 1, -1]):
        read = deck(grids(own) + text)
        (found,) = read.elements
        Mesh(read.nodes, {found.kind: found.nodes})  # which rejects inverted cells
        ends, n = np.array(found.kind.edges), found.kind.n_corners
        middles = read.nodes[found.nodes[0, n:]]
        np.testing.assert_allclose(middles, read.nodes[found.nodes[0, ends]].mean(axis=1), atol=1e-6)


def test_a_missing_middle_node_stands_midway_and_follows_its_corners(deck):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    middles = [(0.5, 0, 0), (0.5, 0.5, 0), (0, 0.5, 0), (0, 0, 0.5), (0.5, 0, 0.5)]  # not that of 3-4
    read = deck(grids([*corners, *middles]) + "CTETRA,1,3,1,2,3,4,5,6\n,7,8,9\nPSOLID,3,5\n" + MATERIAL)
    (cells,) = read.elements
    assert cells.kind is CellType.TETRA10
    added = cells.nodes[0, 9]
    np.testing.assert_allclose(read.nodes[added], [0, 0.5, 0.5])
    assert read.node_ids[added] == 10
    (terms,) = read.constraints
    np.testing.assert_array_equal(terms.dependent, 6 * added + np.arange(3))
    # A rigid motion fulfils them: u = a + b x.
    motion = np.zeros((len(read.nodes), 6))
    motion[:, :3] = np.array([1.0, 2.0, 3.0]) + np.cross([0.1, 0.2, -0.3], read.nodes)
    sums = np.bincount(terms.rows, terms.factors * motion.ravel()[terms.freedoms])
    np.testing.assert_allclose(sums, 0, atol=1e-15)
    assert any(note.startswith("1 sides of quadratic solids") for note in read.notes)


def test_anisotropic_solids_have_the_axes_of_their_system(deck):
    """MAT9 that is isotropic is the isotropic stiffness; its order xy yz zx becomes yz xz xy."""
    text = (
        grids(PRISM[[0, 1, 2, 3]])
        + "CORD2R,4,,0.,0.,0.,1.,0.,0.\n,0.,1.,0.\nCTETRA,1,3,1,2,3,4\nPSOLID,3,8,4\n"
        + "MAT9,8,1.,2.,3.,4.,5.,6.,7.\n,8.,9.,10.,11.,12.,13.,14.,15.\n,16.,17.,18.,19.,20.,21.,22.\n"
    )
    read = deck(text)
    material = next(iter(read.properties.values())).material
    assert isinstance(material, AnisotropicMaterial)
    assert material.density == 22.0
    C = material.elasticity
    np.testing.assert_array_equal(C, C.T)
    # G11 .. G16 of the card: xx with xx, yy, zz, xy, yz, zx.
    np.testing.assert_array_equal(C[0], [1, 2, 3, 5, 6, 4])
    assert (C[5, 5], C[3, 3], C[4, 4]) == (16, 19, 21)
    # System 4 has its z along x and its x along y, so its y along z.
    np.testing.assert_allclose(read.elements[0].directions, [[[0, 0, 1], [1, 0, 0], [0, 1, 0]]])


def test_engineering_constants_of_a_solid(deck):
    """MAT11 of an isotropic material is its stiffness."""
    E, nu = 2.0, 0.25
    G, lame = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    read = deck(
        grids(PRISM[[0, 1, 2, 3]])
        + f"CTETRA,1,3,1,2,3,4\nPSOLID,3,8\nMAT11,8,{E},{E},{E},{nu},{nu},{nu},{G}\n,{G},{G},7.\n"
    )
    C = next(iter(read.properties.values())).material.elasticity
    np.testing.assert_allclose(C[:3, :3], lame + 2 * G * np.eye(3))
    np.testing.assert_allclose(C[3:, 3:], G * np.eye(3))


def test_layered_solids_of_one_material(deck):
    text = grids(PRISM[[0, 1, 2, 3]]) + "CTETRA,1,3,1,2,3,4\n" + MATERIAL
    same = deck(text + "PCOMPS,3\n,1,5,.1\n,2,5,.2\n")
    assert next(iter(same.properties.values())).material == STEEL
    mixed = deck(text + "MAT1,6,1.,,.3\nPCOMPS,3\n,1,5,.1\n,2,6,.2\n")
    assert not mixed.elements
    assert [(each.card, each.count) for each in mixed.left_out] == [("CTETRA", 1)]


# --- shells


@pytest.mark.parametrize(
    ("cards", "cells"),
    [
        ("CQUAD4,7,9,1,2,3,4", 2),
        ("CQUADR,7,9,1,2,3,4", 2),
        ("CTRIA3,7,9,1,2,3\nCTRIA3,8,9,1,3,4", 2),
        ("CTRIAR,7,9,1,2,3\nCTRIAR,8,9,1,3,4", 2),
        ("CQUAD8,7,9,1,2,3,4,5,6\n,7,8", 6),
        ("CQUAD8,7,9,1,2,3,4,5,6\n,7", 5),
        ("CQUAD8,7,9,1,2,3,4,5", 3),
        ("CQUAD8,7,9,1,2,3,4,5,6", 4),
        ("CQUAD8,7,9,1,2,3,4,5,0\n,7", 4),
        ("CQUAD8,7,9,1,2,3,4", 2),
        ("CTRIA6,7,9,1,2,3,5,6,9\nCTRIA3,8,9,1,3,4", 5),
        ("CTRIA6,7,9,1,2,3,5\nCTRIA3,8,9,1,3,4", 3),
        ("CTRIA6,7,9,1,2,3,5,6\nCTRIA3,8,9,1,3,4", 4),
    ],
)
def test_shells_cover_the_same_area_the_same_way_up(deck, cards, cells):
    text = (
        SQUARE + "GRID,5,,1.,0.,0.\nGRID,6,,2.,.5,0.\nGRID,7,,1.,1.,0.\nGRID,8,,0.,.5,0.\nGRID,9,,1.,.5,0.\n"
    )
    read = deck(text + cards + "\nPSHELL,9,5,.1,5,,5\n" + MATERIAL)
    x = read.nodes[np.concatenate([found.nodes for found in read.elements])]
    assert len(x) == cells
    areas = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])[:, 2] / 2
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(2.0)
    assert list(read.properties.values()) == [ShellProperty(STEEL, 0.1, shear_factor=5 / 6)]
    assert not read.left_out


def test_a_warped_quadrilateral_has_the_mass_of_its_mean_plane(deck):
    """A corner raised by h: triangles of normals (-h, -h, 2)/2 and z; the mean plane has their sum."""
    h = 0.4
    text = SQUARE.replace("GRID,3,,2.,1.,0.", f"GRID,3,,2.,1.,{h}") + "PSHELL,9,5,.1,5,,5\n" + MATERIAL
    read = deck(text + "CQUAD4,7,9,1,2,3,4\n")
    x = read.nodes
    mean = np.linalg.norm(np.cross(x[2] - x[0], x[3] - x[1])) / 2
    assert deck_mass(read).mass == pytest.approx(785.0 * mean, rel=1e-12)
    assert deck_mass(deck(text + "CTRIA3,7,9,1,2,3\nCTRIA3,8,9,1,3,4\n")).mass > 785.0 * mean * 1.001
    (flat,) = deck(SQUARE + "CQUAD4,7,9,1,2,3,4\nPSHELL,9,5,.1,5,,5\n" + MATERIAL).elements
    assert flat.mass_share is None


def test_a_wall_by_four_equal_materials_is_homogeneous(deck):
    made = wall(deck, "PSHELL,9,5,.1,5,1.,5,.833333,3.\n")
    assert made == ShellProperty(STEEL, 0.1, 3.0, 0.0, 0.833333)


def test_a_wall_by_its_parts(deck):
    """12I/T^3 = 2, TS/T = 0.5, a membrane alone: A, D and the shear stiffness by their formulas."""
    C = 2.1e11 / (1 - 0.09) * np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]])
    G = 2.1e11 / 2.6
    made = wall(deck, "PSHELL,9,5,.1,5,2.,5,.5,3.\n")
    assert isinstance(made, WallProperty)
    np.testing.assert_allclose(made.membrane, 0.1 * C)
    np.testing.assert_allclose(made.bending, 2 * 0.1**3 / 12 * C)
    np.testing.assert_allclose(made.shear, 0.5 * 0.1 * G * np.eye(2))
    assert made.mass_per_area == pytest.approx(785.0 + 3.0)
    membrane = wall(deck, "PSHELL,9,5,.1,0,,0\n")
    assert not membrane.bending.any()
    assert membrane.shear is None
    np.testing.assert_allclose(membrane.membrane, 0.1 * C)


def test_coupling_of_membrane_and_bending(deck):
    """A homogeneous wall beside its nodes, given by MID4, is that given by ZOFFS.

    Nastran's curvature is that of the other side:  B = -T^2 G4,  so an offset z wants G4 = -z / T C.
    """
    z = 0.03
    D = 1 + 12 * (z / 0.1) ** 2  # of the bending, by the parallel-axis theorem
    C = 2.1e11 / (1 - 0.09)
    G11, G12, G33 = (f"{-z / 0.1 * factor * C:.9e}" for factor in (1, 0.3, 0.35))
    four = f"MAT2,6,{G11},{G12},0.,{G11},0.,{G33}\n"
    by_material = wall(deck, f"PSHELL,9,5,.1,5,{D}\n,,,6\n" + four.replace("e+", "+"))
    text = SQUARE + MATERIAL + "CQUAD4,7,9,1,2,3,4,,.03\nPSHELL,9,5,.1,5,1.000001\n"
    (by_offset,) = deck(text).properties.values()
    for name in ("membrane", "coupling", "bending"):
        np.testing.assert_allclose(getattr(by_material, name), getattr(by_offset, name), rtol=1e-5, atol=1e-3)


def test_what_elements_say_of_their_wall(deck):
    """T1 .. T4 count by their mean, a blank one as T; ZOFFS and TFLAG; each combination is a property."""
    text = SQUARE + MATERIAL + "PSHELL,9,5,.1,5,,5\n"
    elements = [
        "CQUAD4,1,9,1,2,3,4",
        "CQUAD4,2,9,1,2,3,4,,.01\n,,,.2,.2,.4,.4",
        "CQUAD4,3,9,1,2,3,4\n,,,.2,,0.,",
        "CTRIA3,4,9,1,2,3\n,,1,2.,3.,4.",
        "CQUAD8,5,9,1,2,3,4\n,,,.2,.2,.4,.4,,.01",
        "CTRIA6,6,9,1,2,3\n,,.02,.2,.3,.4",
    ]
    read = deck(text + "\n".join(elements) + "\n")
    made = {found.ids[0]: read.properties[found.property] for found in read.elements}
    assert made[1] == ShellProperty(STEEL, 0.1, shear_factor=5 / 6)
    assert made[2] == made[5] == ShellProperty(STEEL, pytest.approx(0.3), 0.0, 0.01, 5 / 6)
    assert made[3].thickness == pytest.approx((0.2 + 0.1 + 0.0 + 0.1) / 4)
    assert made[4].thickness == pytest.approx(0.3)
    assert made[6] == ShellProperty(STEEL, pytest.approx(0.3), 0.0, 0.02, 5 / 6)
    assert sorted(read.element_sets["pshell_9"]) == [1, 2, 3, 4, 5, 6]


def test_isotropic_plies_are_a_plate(deck):
    """PCOMP and PCOMPG of one material against PSHELL; a symmetric lay-up against all its plies."""
    plate = wall(deck, "PSHELL,9,5,.4,5,1.000001,5,,3.\n")
    plies = [
        "PCOMP,9,,3.\n,5,.1,0.,,5,.3,45.\n",
        "PCOMP,9,,3.,,,,,SYM\n,5,.1,30.,YES,,.1,-20.\n",
        "PCOMPG,9,,3.\n,1,5,.1,0.,YES\n,2,5,.3,45.\n",
        "PCOMP,9,,3.,,,,,SMEAR\n,5,.1,0.,,5,.3,45.\n",
    ]
    for text in plies:
        made = wall(deck, text)
        for name in ("membrane", "bending", "shear"):
            np.testing.assert_allclose(getattr(made, name), getattr(plate, name), rtol=1e-5, atol=1e3)
        assert np.abs(made.coupling).max() < 1e-6 * np.abs(made.membrane).max()
        assert made.mass_per_area == pytest.approx(0.4 * 7850 + 3)
    below = wall(deck, "PCOMP,9,0.\n,5,.1,0.,,5,.3,45.\n")
    np.testing.assert_allclose(below.coupling, 0.2 * plate.membrane, rtol=1e-5, atol=1e3)
    assert below.mass_moment_per_area == pytest.approx(0.2 * below.mass_per_area)


def test_orthotropic_plies_by_laminate_theory(deck):
    """[0/90/90/0]: A11 = A22, D11 > D22 by (Q11 7/8 + Q22 1/8) / (Q11 1/8 + Q22 7/8), no coupling."""
    text = "PCOMP,9,,,,,,,SYM\n,8,.1,0.,,8,.1,90.\nMAT8,8,140.,10.,.3,5.,5.,3.,1.6\n"
    made = wall(deck, text)
    d = 1 - 0.09 * 10 / 140
    Q11, Q22 = 140 / d, 10 / d
    assert made.membrane[0, 0] == pytest.approx(made.membrane[1, 1]) == pytest.approx(0.2 * (Q11 + Q22))
    assert made.bending[0, 0] / made.bending[1, 1] == pytest.approx((7 * Q11 + Q22) / (Q11 + 7 * Q22))
    assert made.mass_per_area == pytest.approx(0.64)
    # Rotated by 90 degrees, x and y change places.
    turned = wall(deck, text.replace("0.,,8,.1,90.", "90.,,8,.1,0."))
    np.testing.assert_allclose(turned.bending[::-1, ::-1][1:, 1:], made.bending[:2, :2])


@pytest.mark.parametrize("words", ["3.+9,", ",2.+9"])
def test_one_blank_shear_modulus_is_left_out(deck, words):
    text = SQUARE + "CQUAD4,7,9,1,2,3,4\nPCOMP,9\n,8,.1,,,8,.1\nMAT8,8,1.4+11,1.+10,.3,5.+9,"
    (left,) = deck(text + words + "\n").left_out
    assert (left.card, left.count) == ("MAT8", 1)
    assert not deck(text + "3.+9,2.+9\n").left_out


def test_directions_of_a_material(deck):
    """THETA turns from the side G1-G2; MCID is the x axis of a system; a whole number is always a system."""
    text = (
        SQUARE
        + "MAT8,8,140.,10.,.3,5.,5.,3.,1.6\nPCOMP,9\n,8,.1,0.\nCORD2C,3,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
    )
    for words, expected in [
        ("1,2,3,4", [1, 0, 0]),
        ("2,3,4,1", [0, 1, 0]),
        ("1,2,3,4,30.", [np.sqrt(0.75), 0.5, 0]),
        ("1,4,3,2,30.", [0.5, np.sqrt(0.75), 0]),  # seen from below
        ("1,2,3,4,0", [1, 0, 0]),
        ("2,3,4,1,0", [1, 0, 0]),
        ("1,2,3,4,3", np.array([2, 1, 0]) / np.sqrt(5)),  # radially, at the middle (1, 1/2)
    ]:
        (found,) = deck(text + f"CQUAD4,7,9,{words}\n").elements
        np.testing.assert_allclose(found.directions, np.tile(expected, (2, 1)), atol=1e-12, err_msg=words)


# --- what is left out, what is wrong


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("PSHELL,9,6,.1,6\n", "its material 6 is not defined"),
        ("MAT10,6,1.\nPSHELL,9,6,.1,6\n", r"they are fluid \(MAT10\)"),
        ("MAT3,6,1.\nPSHELL,9,6,.1,6\n", "its material 6 is a MAT3, which is not read"),
        ("MAT9,6,1.\nPSHELL,9,6,.1,6\n", "its material 6 is a MAT9, which these elements do not support"),
        ("MAT1,6\nPSHELL,9,6,.1,6\n", "its material 6 has no stiffness"),
        ("MAT1,6,1.,,.7\nPSHELL,9,6,.1,6\n", "Poisson's ratio of its material 6 is 0.7"),
        ("PSHELL,9,5,.1,-1\n", "plane strain"),
        ("PSHELL,9,5\n", "its property has no thickness"),
        ("PSHELL,9\n", "its property names no material"),
        ("PSHELL,8,5,.1\n", "their property 9 is not defined or not supported"),
        ("PCOMP,9\n", "its property has no plies"),
        ("PCOMP,9,,,,,,,SMCORE\n,5,.1\n", "LAM = SMCORE"),
        ("PCOMP,9,,,,,,,OTHER\n,5,.1\n", "the option LAM = OTHER"),
        ("PCOMP,9\n,8,.1\nMAT8,8,1.,0.\n", "its material 8 has no stiffness"),
    ],
)
def test_shells_that_are_left_out(deck, text, meaning):
    read = deck(SQUARE + MATERIAL + "CQUAD4,7,9,1,2,3,4\n" + text)
    assert not read.elements
    (left,) = [each for each in read.left_out if each.card == "CQUAD4"]
    assert (left.count, left.line) == (1, 6)
    assert left.meaning.startswith("elements left out: ")
    with pytest.raises(AssertionError, match=meaning):
        raise AssertionError(left.meaning)


def test_materials_of_one_isotropic_set(deck):
    """E, G and NU fill each other in; where they do not fit, shear goes by G."""
    for words, expected in [
        ("2.6,1.,", IsotropicMaterial(2.6, pytest.approx(0.3), 0.0)),
        (",1.,.3", IsotropicMaterial(pytest.approx(2.6), 0.3, 0.0)),
        ("2.6,2.,.3", IsotropicMaterial(2.6, 0.3, 0.0, 2.0)),
        ("2.6,.5", IsotropicMaterial(2.6, 0.0, 0.0, 0.5)),
        ("2.6,.5,1.6", IsotropicMaterial(2.6, 0.0, 0.0, 0.5)),
        ("2.6", IsotropicMaterial(2.6, 0.0, 0.0)),
    ]:
        read = deck(grids(PRISM[[0, 1, 2, 3]]) + f"CTETRA,1,3,1,2,3,4\nPSOLID,3,5\nMAT1,5,{words}\n")
        assert next(iter(read.properties.values())).material == expected
    assert any("gives E alone" in note for note in read.notes)
    solid = grids(PRISM[[0, 1, 2, 3]]) + "CTETRA,1,3,1,2,3,4\nPSOLID,3,5\n"
    (left,) = deck(solid + "MAT1,5,2.6,.5\n").left_out
    assert left.card == "MAT1"
    assert "0 is used" in left.meaning
    plain = deck(solid + "MAT1,5,2.6,1.\n")
    assert not plain.left_out
    assert not any("gives E alone" in note for note in plain.notes)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("CQUAD4,7,9,1,2,3,99\n", "line 6: CQUAD4: element 7 names grid 99.*add its GRID card"),
        ("CQUAD8,7,9,1,2,3,4,99\n", "line 6: CQUAD8: element 7 names grid 99"),
        ("CTETRA,7,3,1,2,3,99\nPSOLID,3,5\n", "line 6: CTETRA: element 7 names grid 99"),
        ("CTETRA,7,3,1,2,3,4,99\nPSOLID,3,5\n", "line 6: CTETRA: element 7 names grid 99"),
        ("CQUAD4,7,9,1,3,2,4\n", "line 6: CQUAD4: element 7: its sides cross"),
        ("CQUAD4,7,9,1,2,3,4\nCTRIA3,7,9,1,2,3\n", "line 7: CTRIA3: element 7 is defined a second.*line 6"),
        ("CQUAD4,7,9,1,2,3,4,6\nPCOMP,9\n,5,.1\n", "line 6: CQUAD4: names coordinate system 6"),
        ("PSHELL,9,5,.1\nPSHELL,9,5,.2\n", "line 7: PSHELL: property 9 is defined a second.*line 6"),
        ("MAT1,5,1.\n", "line 6: MAT1: material 5 is defined a second.*line 5"),
        ("PCOMP,9\n,5,.1,0.,,,x\nCQUAD4,7,9,1,2,3,4\n", r"PCOMP: a ply's thickness \(field 7\) is 'X'"),
    ],
)
def test_what_is_wrong_with_cells(deck, text, message):
    extra = "" if "PSHELL" in text or "PCOMP" in text else "PSHELL,9,5,.1,5\n"
    with pytest.raises(ImportFormatError, match=message):
        deck(SQUARE + MATERIAL + text + extra)


@pytest.mark.parametrize(
    ("parameter", "lumped"), [("", True), ("PARAM,COUPMASS,1\n", False), ("PARAM,COUPMASS,-1\n", True)]
)
def test_mass_is_lumped_unless_coupmass_asks_for_that_of_shape_functions(deck, parameter, lumped):
    read = deck(SQUARE + MATERIAL + parameter + "CQUAD4,7,9,1,2,3,4\nPSHELL,9,5,.1,5,,5\n")
    assert read.lumped_mass is lumped


@pytest.mark.parametrize("text", ["PCOMP,9,1.+300\n,5,.1\n", "PSHELL,9,5,1.+200,5,2.\n"])
def test_values_beyond_numbers_leave_elements_out(deck, text):
    (left,) = deck(SQUARE + MATERIAL + "CQUAD4,7,9,1,2,3,4\n" + text).left_out
    assert left.meaning.endswith("its values are too large or too small")
