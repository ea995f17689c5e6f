"""Sections of Abaqus decks: masses, walls, beams and axes beside closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.abaqus_decks import STEEL, brick, element_rows, node_rows

from supple.body import deck_frequencies, deck_models, mass_of_models
from supple.errors import ImportFormatError, MeshError
from supple.importers import read_abaqus
from supple.importers.abaqus.beam_shapes import beam_shape
from supple.importers.deck import RodProperty, ShellProperty, WallProperty
from supple.mesh import CellType, block
from supple.mesh.reference_cell import reference_nodes

SQUARE8 = np.array(
    [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [1, 0, 0], [2, 0.5, 0], [1, 1, 0], [0, 0.5, 0]]
)
TRIANGLE6 = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
LINE3 = np.array([[0, 0, 0], [1, 0, 0], [2.0, 0, 0]])


def total(made):
    return mass_of_models(list(deck_models(made).values()))


# --- elements


@pytest.mark.parametrize(
    ("name", "kind", "volume"),
    [
        ("C3D4", CellType.TETRA4, 1 / 6), ("C3D10", CellType.TETRA10, 1 / 6),
        ("C3D10M", CellType.TETRA10, 1 / 6), ("C3D10T", CellType.TETRA10, 1 / 6),
        ("C3D5", CellType.PYRAMID5, 4 / 3), ("C3D6", CellType.WEDGE6, 1.0), ("C3D15", CellType.WEDGE15, 1.0),
        ("C3D8", CellType.HEXA8, 8.0), ("C3D8R", CellType.HEXA8, 8.0), ("C3D8I", CellType.HEXA8, 8.0),
        ("C3D20", CellType.HEXA20, 8.0), ("C3D20RH", CellType.HEXA20, 8.0), ("SC8R", CellType.HEXA8, 8.0),
    ],
)  # fmt: skip
def test_solids(deck, name, kind, volume):
    text = node_rows(reference_nodes(kind)) + element_rows(name, [np.arange(kind.n_nodes)]) + STEEL
    made = deck(text + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n")
    assert made.left_out == ()
    assert made.elements[0].kind is kind
    assert total(made).mass == pytest.approx(7850 * volume, rel=1e-12)


def rod_of_three(name):
    """A free bar of three hexahedra of second order in a row."""
    mesh = block(0.3, 0.1, 0.1, 3, 1, 1, CellType.HEXA20)
    text = node_rows(mesh.nodes) + element_rows(name, mesh.cells[CellType.HEXA20])
    return text + STEEL + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n"


def test_reduced_integration_softens_coarse_cells_and_leaves_no_mechanism(deck):
    """Beside the same bar refined to 6 x 2 x 2; eight points alone leave four motions without energy."""
    mesh = block(0.3, 0.1, 0.1, 6, 2, 2, CellType.HEXA20)
    text = node_rows(mesh.nodes) + element_rows("C3D20", mesh.cells[CellType.HEXA20])
    fine = deck(text + STEEL + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n")
    exact = deck_frequencies(fine, 4)
    full, reduced = (deck_frequencies(deck(rod_of_three(name)), 4) for name in ("C3D20", "C3D20R"))
    # The third is torsion, which warps the section of a single cell as little in both.
    assert (exact[[0, 1, 3]] < reduced[[0, 1, 3]]).all()
    assert (reduced[[0, 1, 3]] < full[[0, 1, 3]]).all()
    assert reduced[2] == pytest.approx(full[2])
    assert deck(rod_of_three("C3D20RH")).elements[0].reduced


@pytest.mark.parametrize(
    ("name", "nodes", "cells", "area"),
    [
        ("S3", TRIANGLE6[:3], 1, 2.0), ("STRI3", TRIANGLE6[:3], 1, 2.0), ("S6", TRIANGLE6, 4, 2.0),
        ("STRI65", TRIANGLE6, 4, 2.0), ("S4", SQUARE8[:4], 2, 2.0), ("S4R", SQUARE8[:4], 2, 2.0),
        ("S4R5", SQUARE8[:4], 2, 2.0), ("S8", SQUARE8, 6, 2.0), ("S8R", SQUARE8, 6, 2.0),
        ("S9R5", np.vstack([SQUARE8, [1, 0.5, 0]]), 6, 2.0),
    ],
)  # fmt: skip
def test_shells(deck, name, nodes, cells, area):
    text = node_rows(nodes) + element_rows(name, [np.arange(len(nodes))]) + STEEL
    made = deck(text + "*SHELL SECTION, ELSET=all, MATERIAL=steel\n0.01\n")
    assert made.elements[0].kind is CellType.TRIANGLE3
    assert len(made.elements[0].nodes) == cells
    corners = made.nodes[made.elements[0].nodes]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normals[:, 2] > 0).all()
    assert total(made).mass == pytest.approx(7850 * 0.01 * area, rel=1e-12)


def test_a_quadrilateral_with_a_repeated_node_is_a_triangle(deck):
    text = node_rows(TRIANGLE6[:3]) + element_rows("S4", [[0, 1, 2, 2]]) + STEEL
    made = deck(text + "*SHELL SECTION, ELSET=all, MATERIAL=steel\n0.01\n")
    assert len(made.elements[0].nodes) == 1


@pytest.mark.parametrize(
    ("row", "kind", "volume"),
    [
        ([0, 1, 2, 2, 4, 5, 6, 6], CellType.WEDGE6, 4.0), ([0, 1, 2, 3, 4, 4, 7, 7], CellType.WEDGE6, 4.0),
        ([0, 1, 2, 3, 4, 4, 4, 4], CellType.PYRAMID5, 8 / 3),
        ([0, 1, 2, 2, 4, 4, 4, 4], CellType.TETRA4, 4 / 3),
    ],
)  # fmt: skip
def test_hexahedra_with_repeated_nodes_are_simpler_cells(deck, row, kind, volume):
    text = node_rows(reference_nodes(CellType.HEXA8)) + element_rows("C3D8", [row]) + STEEL
    made = deck(text + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n")
    assert [each.kind for each in made.elements] == [kind]
    assert total(made).mass == pytest.approx(7850 * volume)


@pytest.mark.parametrize(
    ("name", "row"),
    [
        ("C3D8", [0, 1, 2, 3, 4, 5, 6, 6]), ("C3D8", [0, 1, 2, 3, 4, 4, 4, 7]),
        ("C3D6", [0, 1, 2, 4, 5, 5]),
    ],
)  # fmt: skip
def test_solids_with_repeated_nodes_that_are_no_simpler_cell_are_left_out(deck, tmp_path, name, row):
    nodes = node_rows(reference_nodes(CellType.HEXA8))
    good = element_rows("C3D8", [np.arange(8)], first=7)
    text = nodes + good + element_rows(name, [row]) + STEEL + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n"
    made = deck(text)
    (left,) = made.left_out
    assert (left.card, left.count, left.line) == (f"*ELEMENT, TYPE={name}", 1, 13)
    assert left.meaning.startswith("elements with repeated nodes")
    assert [each.ids.tolist() for each in made.elements] == [[7]]
    with pytest.raises(MeshError, match=r"line 13: element 1: .* with a repeated node"):
        read_abaqus(tmp_path / "deck.inp")


@pytest.mark.parametrize("name", ["T3D2", "T3D3"])
def test_trusses_have_the_area_of_their_solid_section(deck, name):
    nodes = LINE3 if name == "T3D3" else LINE3[[0, 2]]
    text = node_rows(nodes) + element_rows(name, [np.arange(len(nodes))]) + STEEL
    made = deck(text + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n3e-4\n")
    rod = made.properties["all"]
    assert isinstance(rod, RodProperty)
    assert (rod.area, rod.mass_per_length) == (3e-4, 3e-4 * 7850)
    assert [len(each.nodes) for each in made.elements] == [len(nodes) - 1]


def test_plane_elements_carry_sets_beside_solids_alone(deck):
    nodes, cells = brick((1, 1, 1), (1, 1, 1))
    plane = "*ELEMENT, TYPE=CPS4, ELSET=face\n9, 1, 2, 4, 3\n"
    solid = element_rows("C3D8", cells) + STEEL + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n"
    sets = "*SURFACE, NAME=edge\nface, S2\n"
    made = deck(node_rows(nodes) + solid + plane + sets)
    assert made.passed_over["*ELEMENT, TYPE=CPS4"] == 1
    assert made.left_out == ()
    np.testing.assert_array_equal(made.node_sets["edge"], [1, 3])
    alone = deck(node_rows(nodes) + plane)
    assert [(left.card, left.meaning) for left in alone.left_out] == [
        ("*ELEMENT, TYPE=CPS4", "a body is solid, not plane")
    ]


def test_faces_and_edges_of_solids_carry_sets_alone(deck):
    """As meshers write them; a shell that stands away from the solids, without a section, is missing."""
    nodes, cells = brick((1, 1, 1), (1, 1, 1))
    text = (
        node_rows(nodes) + element_rows("C3D8", cells) + STEEL + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n"
    )
    text += "*ELEMENT, TYPE=S4, ELSET=face\n9, 1, 2, 4, 3\n*ELEMENT, TYPE=T3D2, ELSET=edge\n10, 1, 2\n"
    made = deck(text + "*NSET, NSET=held, ELSET=face\n")
    assert made.left_out == ()
    assert made.passed_over["*ELEMENT, TYPE=S4"] == made.passed_over["*ELEMENT, TYPE=T3D2"] == 1
    assert made.node_sets["held"].tolist() == [0, 1, 2, 3]
    away = deck(text + "*NODE\n99, 5., 5., 5.\n*ELEMENT, TYPE=S3, ELSET=fin\n11, 1, 2, 99\n")
    assert [left.card for left in away.left_out] == ["*ELEMENT, TYPE=S3"]


def test_elements_of_an_unknown_type_are_left_out(deck):
    made = deck(node_rows(LINE3) + "*ELEMENT, TYPE=CONN3D2\n1, 1, 2\n2, 2, 3\n")
    (left,) = made.left_out
    assert (left.card, left.count, left.line) == ("*ELEMENT, TYPE=CONN3D2", 2, 5)


# --- walls

SHELL = node_rows(SQUARE8[:4]) + element_rows("S4", [[0, 1, 2, 3]]) + STEEL
LAMINA = "*MATERIAL, NAME=ply\n*ELASTIC, TYPE=LAMINA\n140e9, 10e9, 0.3, 5e9, 5e9, 3e9\n*DENSITY\n1600.\n"


@pytest.mark.parametrize(
    ("offset", "middle"), [("0.5", -0.005), ("SPOS", -0.005), ("SNEG", 0.005), ("0.2", -0.002)]
)
def test_the_middle_lies_away_from_the_nodes(deck, offset, middle):
    """OFFSET: of the nodes from the middle along the normal, in thicknesses."""
    made = deck(SHELL + f"*SHELL SECTION, ELSET=all, MATERIAL=steel, OFFSET={offset}\n0.01\n")
    wall = made.properties["all"]
    assert isinstance(wall, ShellProperty)
    assert wall.offset == pytest.approx(middle)


@pytest.mark.parametrize(("name", "factor"), [("S4", 5 / 6), ("S4R5", 0.0)])
def test_shells_shear_but_for_thin_ones(deck, name, factor):
    text = SHELL.replace("TYPE=S4", f"TYPE={name}")
    assert (
        deck(text + "*SHELL SECTION, ELSET=all, MATERIAL=steel\n0.01\n").properties["all"].shear_factor
        == factor
    )
    plies = deck(text + "*SHELL SECTION, ELSET=all, COMPOSITE\n0.01,, steel\n").properties["all"]
    assert (plies.shear is None) is (factor == 0)


def test_plies_of_one_material_are_a_homogeneous_wall(deck):
    """A = E t / (1 - nu^2), D = A t^2 / 12, B = A z of an offset, shear 5/6 G t."""
    plies = "0.004, 3, steel, 0.\n0.006, 3, steel, 30.\n"
    wall = deck(SHELL + "*SHELL SECTION, ELSET=all, COMPOSITE, OFFSET=SPOS\n" + plies).properties["all"]
    A = 2.1e11 * 0.01 / 0.91 * np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]])
    np.testing.assert_allclose(wall.membrane, A, rtol=1e-12, atol=1e-3)
    np.testing.assert_allclose(wall.coupling, -0.005 * A, rtol=1e-12, atol=1e-5)
    np.testing.assert_allclose(wall.bending, A * (0.01**2 / 12 + 0.005**2), rtol=1e-12, atol=1e-7)
    np.testing.assert_allclose(wall.shear, 5 / 6 * 0.01 * 2.1e11 / 2.6 * np.eye(2), rtol=1e-9, atol=1e-2)
    assert wall.mass_per_area == pytest.approx(78.5)


def test_plies_turn_about_the_normal(deck):
    """A ply at 90 degrees swaps the moduli; its orientation by name is the same as its angle."""
    axes = "*ORIENTATION, NAME=along\n1., 0., 0., 0., 1., 0.\n3, 0.\n"
    across = "*ORIENTATION, NAME=across\n0., 1., 0., -1., 0., 0.\n3, 0.\n"
    head = SHELL + LAMINA + axes + across
    straight, turned, named = (
        deck(head + "*SHELL SECTION, ELSET=all, COMPOSITE\n" + plies).properties["all"]
        for plies in (
            "0.001,, ply, 0.\n0.001,, ply, 0.\n",
            "0.001,, ply, 0.\n0.001,, ply, 90.\n",
            "0.001,, ply, along\n0.001,, ply, across\n",
        )
    )
    Q11, Q22 = straight.membrane[0, 0] / 0.002, straight.membrane[1, 1] / 0.002
    assert pytest.approx(140e9 / (1 - 0.09 * 10 / 140)) == Q11
    np.testing.assert_allclose(np.diag(turned.membrane)[:2], 0.001 * (Q11 + Q22) * np.ones(2))
    for part in ("membrane", "coupling", "bending", "shear"):
        np.testing.assert_allclose(getattr(named, part), getattr(turned, part), rtol=1e-9, atol=1e-3)


def same_walls(first, second):
    for part in ("membrane", "coupling", "bending", "shear", "mass_per_area", "rotary_inertia_per_area"):
        a, b = getattr(first, part), getattr(second, part)
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * max(np.abs(first.membrane).max(), 1))


def test_symmetric_plies_are_repeated_in_reverse(deck):
    half = "0.001,, ply, 0.\n0.002,, steel, 0.\n0.001,, ply, 30.\n"
    rest = "0.001,, ply, 30.\n0.002,, steel, 0.\n0.001,, ply, 0.\n"
    head = SHELL + LAMINA + "*SHELL SECTION, ELSET=all, COMPOSITE"
    wall, whole = (
        deck(text).properties["all"] for text in (f"{head}, SYMMETRIC\n{half}", f"{head}\n{half}{rest}")
    )
    assert wall.thickness == pytest.approx(0.008)
    same_walls(wall, whole)


@pytest.mark.parametrize("section", ["MATERIAL=steel\n0.01\n", "COMPOSITE\n0.01,, steel\n"])
@pytest.mark.parametrize("keyword", ["SHELL SECTION", "SHELL GENERAL SECTION"])
def test_a_density_of_the_section_is_mass_besides_that_of_the_material(deck, keyword, section):
    made = deck(SHELL + f"*{keyword}, ELSET=all, DENSITY=50., {section}")
    assert total(made).mass == pytest.approx(2 * (78.5 + 50))
    assert made.left_out == ()


def test_options_that_are_not_read_are_left_out(deck):
    made = deck(SHELL + "*SHELL GENERAL SECTION, ELSET=all, MATERIAL=steel, BENDING ONLY\n0.01\n")
    (left,) = made.left_out
    assert left.card == "*SHELL GENERAL SECTION, BENDINGONLY"
    assert left.meaning == "the wall has membrane stiffness as well"


AXES = "*ORIENTATION, NAME=along\n1., 0., 0., 0., 1., 0.\n3, 0.\n"
AXES += "*ORIENTATION, NAME=aside\n1., 1., 0., -1., 1., 0.\n3, 0.\n"


@pytest.mark.parametrize(
    ("axes", "named", "angles"),
    [
        ("along", ["aside", "-15."], [45, -15]), ("aside", ["along", "20.", ""], [-45, 20, 0]),
        ("aside", ["along", "aside"], [-45, 0]),
    ],
)  # fmt: skip
@pytest.mark.parametrize("side", [1, -1])
def test_plies_count_from_the_axes_of_the_section(deck, axes, named, angles, side):
    """An angle turns about the normal of the wall, also where the axes by name have the opposite normal."""
    order = [0, 1, 2, 3] if side > 0 else [0, 3, 2, 1]
    text = node_rows(SQUARE8[:4]) + element_rows("S4", [order]) + STEEL + LAMINA + AXES
    text += f"*SHELL SECTION, ELSET=all, COMPOSITE, ORIENTATION={axes}\n"
    made = deck(text + "".join(f"0.001,, ply, {each}\n" for each in named))
    turned = [angle * (side if name.isalpha() else 1) for name, angle in zip(named, angles, strict=True)]
    plain = deck(text + "".join(f"0.001,, ply, {angle}.\n" for angle in turned))
    same_walls(made.properties["all"], plain.properties["all"])
    np.testing.assert_allclose(made.elements[0].directions, plain.elements[0].directions)
    assert made.left_out == ()


@pytest.mark.parametrize(
    ("plies", "meaning"),
    [
        ("0.001,, ply, aside\n0.001,, ply, 0.\n", "some plies have axes by name"),
        ("0.001,, ply, aside\n0.001,, ply\n", "some plies have axes by name"),
        ("0.001,, ply, aside\n0.001,, ply, round\n", "its plies have axes that are not rotated by one"),
    ],
)
def test_plies_of_several_kinds_of_axes_are_left_out(deck, plies, meaning):
    round_axes = "*ORIENTATION, NAME=round, SYSTEM=CYLINDRICAL\n0., 0., 0., 0., 0., 1.\n3, 0.\n"
    made = deck(SHELL + LAMINA + AXES + round_axes + "*SHELL SECTION, ELSET=all, COMPOSITE\n" + plies)
    assert made.left_out[0].meaning.startswith(meaning)


@pytest.mark.parametrize(
    ("axes", "section", "direction"),
    [
        ("", "", [1, 0, 0]),
        ("*ORIENTATION, NAME=o\n0., 1., 0., -1., 0., 0.\n", ", ORIENTATION=o", [0, 1, 0]),
        ("*ORIENTATION, NAME=o\n1., 0., 0., 0., 1., 0.\n3, 30.\n", ", ORIENTATION=o", [3**0.5 / 2, 0.5, 0]),
        ("*ORIENTATION, NAME=o\n0., 0., 1., 1., 0., 0.\n1, 0.\n", ", ORIENTATION=o", [1, 0, 0]),
        (
            "*ORIENTATION, NAME=o, SYSTEM=Z RECTANGULAR\n0., 0., 1., 0., 1., 0.\n",
            ", ORIENTATION=o",
            [0, 1, 0],
        ),
        ("*ORIENTATION, NAME=o\n0., 0., 1., 1., 0., 0.\n, 30.\n", ", ORIENTATION=o", [3**0.5 / 2, 0.5, 0]),
    ],
)
def test_directions_of_plies(deck, axes, section, direction):
    text = SHELL + LAMINA + axes + f"*SHELL SECTION, ELSET=all, MATERIAL=ply{section}\n0.01\n"
    made = deck(text)
    assert made.left_out == ()
    np.testing.assert_allclose(made.elements[0].directions, np.tile(direction, (2, 1)), atol=1e-12)


def test_plies_without_axes_on_a_wall_across_x_run_along_z(deck):
    nodes = SQUARE8[:4][:, [2, 0, 1]]
    text = node_rows(nodes) + element_rows("S4", [[0, 1, 2, 3]]) + LAMINA
    made = deck(text + "*SHELL SECTION, ELSET=all, MATERIAL=ply\n0.01\n")
    np.testing.assert_array_equal(made.elements[0].directions, [[0, 0, 1], [0, 0, 1]])


def test_thickness_by_nodes(deck):
    """0.01 at x = 0 of the section, 0.03 at x = 2: cells have the mean of their nodes, so the same mass."""
    text = SHELL + "*SHELL SECTION, ELSET=all, MATERIAL=steel, NODAL THICKNESS\n0.01\n"
    made = deck(text + "*NSET, NSET=end\n2, 3\n*NODAL THICKNESS\nend, 0.03\n")
    assert sorted(wall.thickness for wall in made.properties.values()) == pytest.approx([0.05 / 3, 0.07 / 3])
    assert total(made).mass == pytest.approx(7850 * 0.02 * 2)
    assert made.left_out == ()


def test_thickness_by_nodes_applies_where_a_section_names_it(deck):
    """Plies are scaled. If no section names it, as in CalculiX, it applies to all homogeneous walls."""
    other = (
        node_rows(SQUARE8[:4] + np.array([0, 0, 1]), 11)
        + "*ELEMENT, TYPE=S4, ELSET=other\n2, 11, 12, 13, 14\n"
    )
    given = "*NSET, NSET=n\n1, 2, 3, 4, 11, 12, 13, 14\n*NODAL THICKNESS\nn, 0.03\n"
    plain = "*SHELL SECTION, ELSET=other, MATERIAL=steel\n0.01\n"
    plies = "*SHELL SECTION, ELSET=all, COMPOSITE{}\n0.002,, steel\n0.004,, steel\n"
    made = deck(SHELL + other + given + plain + plies.format(", NODAL THICKNESS"))
    assert made.properties["all"].mass_per_area == pytest.approx(0.03 * 7850)
    assert made.properties["all"].bending[0, 0] == pytest.approx(2.1e11 * 0.03**3 / 12 / 0.91)
    assert made.properties["other"].thickness == 0.01
    assert made.notes == ()
    made = deck(SHELL + other + given + plain + plies.format(""))
    assert made.properties["all"].mass_per_area == pytest.approx(0.006 * 7850)
    assert made.properties["other"].thickness == pytest.approx(0.03)
    assert made.notes[0].startswith("*NODAL THICKNESS applies to all homogeneous walls")


@pytest.mark.parametrize("kind", [", GENERATE\n1, 3, 2, 1", ", INPUT=other.inp"])
def test_generated_thickness_by_nodes_is_left_out(deck, kind):
    text = SHELL + "*SHELL SECTION, ELSET=all, MATERIAL=steel, NODAL THICKNESS\n0.01\n"
    made = deck(text + f"*NODAL THICKNESS\n1, 0.01\n3, 0.03\n*NODAL THICKNESS{kind}\n")
    assert [(left.card, left.line) for left in made.left_out] == [("*NODAL THICKNESS", 18)]


def test_a_wall_by_its_stiffness(deck):
    values = [f"{i + 1}." for i in range(21)]
    rows = "\n".join(", ".join(values[i : i + 8]) for i in (0, 8, 16))
    wall = deck(SHELL + f"*SHELL GENERAL SECTION, ELSET=all, DENSITY=5.\n{rows}\n").properties["all"]
    assert isinstance(wall, WallProperty)
    np.testing.assert_array_equal(wall.membrane, [[1, 2, 4], [2, 3, 5], [4, 5, 6]])
    np.testing.assert_array_equal(wall.coupling, [[7, 11, 16], [8, 12, 17], [9, 13, 18]])
    np.testing.assert_array_equal(wall.bending, [[10, 14, 19], [14, 15, 20], [19, 20, 21]])
    assert wall.mass_per_area == 5.0


def test_membranes_do_not_bend(deck):
    text = node_rows(SQUARE8[:4]) + element_rows("M3D4", [[0, 1, 2, 3]]) + STEEL
    made = deck(text + "*MEMBRANE SECTION, ELSET=all, MATERIAL=steel\n0.01\n")
    wall = made.properties["all"]
    assert wall.membrane[0, 0] == pytest.approx(2.1e11 * 0.01 / 0.91)
    assert not wall.bending.any()
    assert wall.mass_per_area == pytest.approx(78.5)
    assert total(made).mass == pytest.approx(157)


# --- axes of solids


def test_axes_of_solids_turn_the_material(deck):
    """A bar along y of a material whose first axis lies along y stretches with E1."""
    nodes, cells = brick((0.1, 1, 0.1), (1, 4, 1))
    material = (
        "*MATERIAL, NAME=wood\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
        "12e9, 1e9, 1e9, 0., 0., 0., 1e9, 1e9,\n1e9\n*DENSITY\n500.\n"
    )
    held = "*NSET, NSET=end\n1, 2, 11, 12\n*NSET, NSET=every, GENERATE\n1, 20\n"
    held += "*BOUNDARY\nend, 2\nevery, 1\nevery, 3\n"
    text = node_rows(nodes) + element_rows("C3D8", cells) + material + held
    plain = deck(text + "*SOLID SECTION, ELSET=all, MATERIAL=wood\n")
    axes = "*ORIENTATION, NAME=o\n0., 1., 0., -1., 0., 0.\n"
    turned = deck(text + axes + "*SOLID SECTION, ELSET=all, MATERIAL=wood, ORIENTATION=o\n")
    ratio = deck_frequencies(turned, 1, held=True) / deck_frequencies(plain, 1, held=True)
    np.testing.assert_allclose(ratio, np.sqrt(12), rtol=1e-6)


def test_cylindrical_axes(deck):
    """At a place on the y axis the radial direction is y, the tangential one -x."""
    nodes, cells = brick((0.1, 0.1, 0.1), (1, 1, 1), (-0.05, 0.95, 0.0))
    constants = "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n9e9, 2e9, 3e9, 0., 0., 0., 1e9, 1e9,\n1e9\n"
    axes = "*ORIENTATION, NAME=o, SYSTEM=CYLINDRICAL\n0., 0., 0., 0., 0., 1.\n"
    text = node_rows(nodes) + element_rows("C3D8", cells) + "*MATERIAL, NAME=wood\n" + constants + axes
    made = deck(text + "*SOLID SECTION, ELSET=all, MATERIAL=wood, ORIENTATION=o\n")
    expected = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    np.testing.assert_allclose(made.elements[0].directions[0], expected, atol=1e-12)


# --- beams

POINTS = {
    "RECT": ([0.2, 0.3], lambda y, z: abs(y) < 1, (-0.1, 0.1, -0.15, 0.15)),
    "CIRC": ([0.1], lambda y, z: y * y + z * z < 0.01, (-0.1, 0.1, -0.1, 0.1)),
    "PIPE": ([0.1, 0.02],
             lambda y, z: (y * y + z * z > 0.0064) & (y * y + z * z < 0.01), (-0.1, 0.1, -0.1, 0.1)),
    "BOX": ([0.2, 0.3, 0.01, 0.02, 0.03, 0.04],
            lambda y, z: (y < -0.07) | (y > 0.09) | (z < -0.11) | (z > 0.13), (-0.1, 0.1, -0.15, 0.15)),
    "I": ([0.1, 0.3, 0.2, 0.15, 0.02, 0.03, 0.01],
          lambda y, z: ((z < -0.08) & (abs(y) < 0.1)) | ((z > 0.17) & (abs(y) < 0.075)) | (abs(y) < 0.005),
          (-0.1, 0.1, -0.1, 0.2)),
    "T": ([0.2, 0.3, 0.1, 0.02, 0.01],
          lambda y, z: (z > 0.18) | (abs(y) < 0.005), (-0.1, 0.1, -0.1, 0.2)),
    "L": ([0.2, 0.1, 0.01, 0.02],
          lambda y, z: (z < 0.005) | (y < 0.01), (-0.01, 0.19, -0.005, 0.095)),
    "TRAPEZOID": ([0.2, 0.3, 0.1, 0.05],
                  lambda y, z: abs(y) < 0.1 - (z + 0.05) / 6, (-0.1, 0.1, -0.05, 0.25)),
}  # fmt: skip


def test_a_pipe_with_a_wall_thicker_than_its_radius_is_none():
    assert beam_shape("PIPE", [0.1, 0.12]) is None
    assert beam_shape("PIPE", [0.1, 0.1]).area == pytest.approx(np.pi * 0.01)


@pytest.mark.parametrize("kind", POINTS)
def test_sections_of_beams_beside_sums_over_their_points(kind):
    dimensions, inside, (y0, y1, z0, z1) = POINTS[kind]
    y, z = np.meshgrid(
        y0 + (y1 - y0) * (np.arange(1200) + 0.5) / 1200, z0 + (z1 - z0) * (np.arange(1200) + 0.5) / 1200
    )
    there = inside(y, z)
    y, z, a = y[there], z[there], (y1 - y0) * (z1 - z0) / 1200**2
    made = beam_shape(kind, dimensions)
    assert made.area == pytest.approx(a * y.size, rel=2e-3)
    np.testing.assert_allclose(made.centroid, [y.mean(), z.mean()], atol=1e-4)
    y, z = y - y.mean(), z - z.mean()
    expected = [a * (y * y).sum(), a * (z * z).sum(), a * (y * z).sum()]
    np.testing.assert_allclose([made.I1, made.I2, made.I12], expected, rtol=5e-3, atol=1e-9)


@pytest.mark.parametrize(
    ("kind", "dimensions", "J"),
    [
        ("RECT", [0.1, 0.1], 0.1406 * 0.1**4), ("RECT", [0.2, 0.1], 0.2287 * 0.2 * 0.1**3),
        ("CIRC", [0.1], np.pi * 0.1**4 / 2), ("BOX", [0.1, 0.1, 0.001], 0.099**3 * 0.001),
        ("L", [0.1, 0.1, 0.001, 0.001], (0.0995 + 0.0995) * 0.001**3 / 3),
    ],
)  # fmt: skip
def test_torsion_of_sections(kind, dimensions, J):
    """Rectangles: Timoshenko and Goodier, Theory of Elasticity, section 109."""
    assert beam_shape(kind, dimensions).J == pytest.approx(J, rel=3e-4)


def test_torsion_of_a_triangle_like_trapezoid():
    """Saint-Venant's A^4 / (40 I_p) is within some percent for every compact section; here the square."""
    assert beam_shape("TRAPEZOID", [0.1, 0.1, 0.1, 0.0]).J == pytest.approx(0.1406e-4, rel=0.07)


BEAM = node_rows([[0, 0, z] for z in np.linspace(0, 1, 9)])
CELLS = [[i, i + 1] for i in range(8)]


def test_beams_bend_about_the_axes_of_their_section(deck):
    """n1 along y, 0.01 wide there, 0.03 along n2: f = 1.8751^2 / (2 pi L^2) sqrt(E I / rho A)."""
    text = BEAM + element_rows("B33", CELLS) + STEEL + "*BOUNDARY\n1, ENCASTRE\n"
    made = deck(text + "*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=RECT\n0.01, 0.03\n0., 1., 0.\n")
    wave = 1.8751**2 / (2 * np.pi) * np.sqrt(2.1e11 / 7850 / 12)
    np.testing.assert_allclose(deck_frequencies(made, 2, held=True), wave * np.array([0.01, 0.03]), rtol=2e-3)
    np.testing.assert_allclose(made.elements[0].directions, np.tile([0, 1, 0], (8, 1)), atol=1e-15)
    assert made.properties["all"].first.I1 == pytest.approx(0.03 * 0.01**3 / 12)


def test_the_same_beam_by_numbers_and_by_three_node_elements(deck):
    """I11 bends about the first axis: int x2^2 dA."""
    shape = "*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=RECT\n0.01, 0.03\n0., 1., 0.\n"
    straight = deck(BEAM + element_rows("B31", CELLS) + STEEL + shape)
    rows = [[i, i + 1, i + 2] for i in range(0, 8, 2)]
    quadratic = deck(BEAM + element_rows("B32R", rows) + STEEL + shape)
    np.testing.assert_array_equal(quadratic.elements[0].nodes, straight.elements[0].nodes)
    np.testing.assert_array_equal(quadratic.elements[0].ids, np.repeat([1, 2, 3, 4], 2))
    values = straight.properties["all"].first
    numbers = f"{values.area}, {values.I2}, 0., {values.I1}, {values.J}\n0., 1., 0.\n2.1e11, {2.1e11 / 2.6}\n"
    general = deck(
        BEAM + element_rows("B31", CELLS) + f"*BEAM GENERAL SECTION, ELSET=all, DENSITY=7850.\n{numbers}"
    )
    same = general.properties["all"].first
    assert (same.area, same.I1, same.I2, same.J) == (values.area, values.I1, values.I2, values.J)
    assert same.mass_per_length == pytest.approx(values.mass_per_length)
    assert general.properties["all"].material.poissons_ratio == pytest.approx(0.3)


def test_a_node_gives_the_first_axis(deck):
    text = (
        BEAM + "*NODE\n100, 0., 5., 0.\n*ELEMENT, TYPE=B31, ELSET=all\n1, 1, 2, 100\n2, 2, 3, 100\n" + STEEL
    )
    made = deck(text + "*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=CIRC\n0.01\n")
    np.testing.assert_allclose(made.elements[0].directions, [[0, 1, 0], [0, 1, 0]], atol=1e-12)


def test_centres_of_sections_stand_away_from_the_nodes(deck):
    """The node of this I lies on its bottom; beams hang on their shear centre, mass on the centroid."""
    text = BEAM + element_rows("B31", CELLS) + STEEL
    section = (
        "*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=I\n0., .3, .2, .2, .02, .02, .01\n0., 1., 0.\n"
    )
    made = deck(text + section)
    # n2 = t x n1 = z x y = -x
    np.testing.assert_allclose(made.elements[0].offsets[0], [[-0.15, 0, 0], [-0.15, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(made.properties["all"].first.neutral, [0, 0], atol=1e-12)
    np.testing.assert_allclose(total(made).centre, [-0.15, 0, 0.5], atol=1e-9)


def test_shares_of_the_thickness_move_beams_of_calculix(deck):
    """OFFSET1 = 0.5: the nodes lie on the face at +n1, as of shells."""
    text = BEAM + element_rows("B31", CELLS) + STEEL
    section = "*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=RECT, OFFSET1=0.5\n0.02, 0.03\n0., 1., 0.\n"
    np.testing.assert_allclose(total(deck(text + section)).centre, [0, -0.01, 0.5], atol=1e-9)


def test_centres_that_are_given(deck):
    text = BEAM + element_rows("B31", CELLS)
    section = "*BEAM GENERAL SECTION, ELSET=all, DENSITY=1.\n1., 1., 0., 1., 1.\n0., 1., 0.\n1., .4\n"
    made = deck(text + section + "*CENTROID\n0.1, 0.\n*SHEAR CENTER\n0.3, 0.2\n")
    np.testing.assert_allclose(made.properties["all"].first.neutral, [-0.2, -0.2])
    np.testing.assert_allclose(made.elements[0].offsets[0, 0], [-0.2, 0.3, 0], atol=1e-12)
    assert made.left_out == ()


def test_sections_that_are_not_read_leave_their_beams_out(deck):
    text = BEAM + element_rows("B31", CELLS) + STEEL
    made = deck(text + "*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=ELBOW\n0.1, 0.01, 1.\n")
    assert [left.card for left in made.left_out] == ["*BEAM SECTION, SECTION=ELBOW", "*ELEMENT, TYPE=B31"]
    assert made.left_out[1].count == 8


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("*SHELL SECTION, ELSET=all, MATERIAL=steel\n", "*SHELL SECTION without a thickness"),
        (
            "*SHELL SECTION, ELSET=all, MATERIAL=steel\n0.\n",
            "*SHELL SECTION: the thickness 0 is not positive",
        ),
        ("*SHELL SECTION, ELSET=all, COMPOSITE\n-1.,, steel\n", "a ply of thickness -1"),
        ("*SHELL GENERAL SECTION, ELSET=all\n1., 2.\n", "*SHELL GENERAL SECTION has 21 stiffnesses, not 2"),
        ("*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=RECT\n", "*BEAM SECTION without dimensions"),
        (
            "*BEAM GENERAL SECTION, ELSET=all\n1., 1., 0., 1., 1.\n",
            "*BEAM GENERAL SECTION: its last line begins",
        ),
        ("*ORIENTATION, NAME=o\n1., 0., 0., 2., 0., 0.\n", "*ORIENTATION, NAME=o: its points give no axes"),
    ],
)
def test_errors_of_sections(deck, section, message):
    with pytest.raises(ImportFormatError) as error:
        deck(SHELL + section)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("kind", "dimensions"),
    [
        ("CIRC", [-0.01]), ("PIPE", [0.01, 0.015]), ("RECT", [-0.1, -0.2]),
        ("BOX", [0.1, 0.1, 0.06, 0.06, 0.06, 0.06]), ("I", [0.0, 0.1, 0.1, 0.1, 0.06, 0.06, 0.01]),
        ("L", [0.1, 0.01, 0.02, 0.01]),
    ],
)  # fmt: skip
def test_shapes_that_cannot_be_are_not_read(kind, dimensions):
    assert beam_shape(kind, dimensions) is None


def test_a_distance_from_the_node_may_be_negative():
    assert beam_shape("I", [-0.05, 0.1, 0.1, 0.1, 0.01, 0.01, 0.01]) is not None


def test_tapered_beams_are_left_out(deck):
    text = node_rows(LINE3[:2]) + element_rows("B31", [[0, 1]])
    text += (
        "*BEAM GENERAL SECTION, ELSET=all, SECTION=RECT, TAPER\n0.1, 0.2\n0.2, 0.2\n0., 1., 0.\n2e11, 8e10\n"
    )
    assert deck(text).left_out[0].card == "*BEAM GENERAL SECTION, SECTION=RECT"


def test_a_blank_line_is_the_default_direction_of_beams(deck):
    """Without it, the second line would be read as n1."""
    text = node_rows(LINE3[:2]) + element_rows("B31", [[0, 1]]) + STEEL
    made = deck(text + "*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=RECT\n0.1, 0.2\n\n5, 5\n")
    np.testing.assert_array_equal(made.elements[0].directions, [[0, 0, -1]])


# --- points of stress recovery of beams


@pytest.mark.parametrize(
    ("kind", "dimensions", "points", "extent"),
    [
        ("RECT", [0.2, 0.1], 8, (0.2, 0.1)), ("CIRC", [0.1], 8, (0.2, 0.2)),
        ("PIPE", [0.1, 0.01], 8, (0.2, 0.2)),
        ("BOX", [0.3, 0.2, 0.01, 0.02, 0.01, 0.02], 4, (0.3, 0.2)),
        ("I", [0.1, 0.2, 0.1, 0.1, 0.01, 0.01, 0.005], 4, (0.1, 0.2)),
        ("T", [0.1, 0.2, 0.1, 0.01, 0.005], 6, (0.1, 0.2)), ("L", [0.1, 0.2, 0.01, 0.01], 5, (0.1, 0.2)),
        ("TRAPEZOID", [0.2, 0.1, 0.1, 0.0], 4, (0.2, 0.1)),
    ],
)  # fmt: skip
def test_shapes_bring_their_points(kind, dimensions, points, extent):
    """At the corners of the convex hull, or around a circle."""
    shape = beam_shape(kind, dimensions)
    found = np.array(shape.geometry.points)
    assert len(found) == points
    np.testing.assert_allclose(np.ptp(found, axis=0), extent)
    closed = {"BOX": 1 / (2 * 0.29 * 0.18 * 0.01), "PIPE": 0.1 / shape.J, "CIRC": 0.1 / shape.J}
    if kind in closed:
        np.testing.assert_allclose(np.linalg.norm(shape.geometry.torsion_shear, axis=1), closed[kind])


@pytest.mark.parametrize("a", np.linspace(0.05, 0.11, 13).tolist())
def test_points_of_an_angle_include_its_outer_corner(a):
    """The corner of both legs, whose walls differ there by rounding."""
    found = np.array(beam_shape("L", [a, 0.113, 0.0125, 0.0198]).geometry.points)
    corner = found.min(axis=0)
    assert np.linalg.norm(found - corner, axis=1).min() < 1e-9


def test_section_points_of_a_general_section(deck):
    text = node_rows(LINE3[:2]) + element_rows("B31", [[0, 1]])
    made = deck(
        text
        + "*BEAM GENERAL SECTION, ELSET=all, DENSITY=1\n0.01, 1e-5, 0., 2e-5, 3e-5\n0., 1., 0.\n2e11, 8e10\n"
        "*CENTROID\n0.01, 0.\n*SHEAR CENTER\n0.02, 0.\n*SECTION POINTS\n0.1, 0.05, -0.1, 0.05\n-0.1, -0.05\n"
    )
    (given,) = made.properties.values()
    expected = [[0.08, 0.05], [-0.12, 0.05], [-0.12, -0.05]]
    np.testing.assert_allclose(given.first.geometry.points, expected)
    assert given.first.neutral == pytest.approx((-0.01, 0.0))
    assert made.left_out == ()
