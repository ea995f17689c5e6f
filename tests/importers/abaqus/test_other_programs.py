"""What CalculiX and Abaqus accept beyond the letter of their manuals, and generation of nodes."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import deck_frequencies, deck_parts
from supple.errors import ImportFormatError
from supple.importers.abaqus.beam_shapes import beam_shape
from supple.importers.abaqus.mesh_view import read_abaqus
from supple.mesh import CellType, block

TETRAHEDRON = """*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 0, 1, 0
4, 0, 0, 1
"""
STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n6000\n"


def test_numbers_behind_the_last_node_are_a_note(deck, tmp_path):
    """CalculiX does not read them; a mesh alone, without notes, rejects them."""
    text = TETRAHEDRON + "*ELEMENT, TYPE=C3D4, ELSET=E\n7, 1, 2, 3, 4, 9, 8,\n"
    read = deck(text + STEEL + "*SOLID SECTION, ELSET=E, MATERIAL=STEEL\n")
    np.testing.assert_array_equal(read.elements[0].nodes, [[0, 1, 2, 3]])
    assert "2 more numbers" in " ".join(read.notes)
    (tmp_path / "mesh.inp").write_text(text)
    with pytest.raises(ImportFormatError, match="2 more numbers"):
        read_abaqus(tmp_path / "mesh.inp")


def test_a_restart_names_the_file_that_is_needed(deck):
    with pytest.raises(ImportFormatError, match="line 1: it continues with another analysis"):
        deck("*RESTART, READ, STEP=1\n*STEP\n*STATIC\n*END STEP\n")


def test_two_elements_on_a_line_are_refused(deck):
    with pytest.raises(ImportFormatError, match="on separate lines"):
        deck(TETRAHEDRON + "*ELEMENT, TYPE=C3D4\n7, 1, 2, 3, 4, 8, 1, 2, 3, 4\n")


def test_a_node_without_coordinates_lies_at_the_origin(deck):
    read = deck("*NODE\n1\n2, 1\n3, 0, 1\n4, , ,1\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n" + STEEL)
    np.testing.assert_array_equal(read.nodes, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def test_an_instance_is_no_word_in_a_file_without_instances(deck):
    read = deck(TETRAHEDRON + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n*NSET, NSET=A, INSTANCE=P-1\n2, 3\n")
    np.testing.assert_array_equal(read.node_sets["A"], [1, 2])
    assert any("no instance 'P-1'" in note for note in read.notes)


def test_a_box_of_one_missing_wall_is_an_open_profile():
    """J = sum(s t^3) / 3 of what stands (Megson, Aircraft Structures, section 18.2)."""
    shape = beam_shape("BOX", [25.0, 50.0, 1e-4, 3.0, 3.0, 3.0])
    assert shape is not None
    assert shape.J == pytest.approx(27 * (47 + 2 * 23.5) / 3, rel=0.02)


# --- tied contact


TWO_BRICKS = """*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
11, 0, 0, 1
12, 1, 0, 1
13, 1, 1, 1
14, 0, 1, 1
15, 0, 0, 2
16, 1, 0, 2
17, 1, 1, 2
18, 0, 1, 2
*ELEMENT, TYPE=C3D8, ELSET=E
1, 1, 2, 3, 4, 5, 6, 7, 8
2, 11, 12, 13, 14, 15, 16, 17, 18
*SOLID SECTION, ELSET=E, MATERIAL=STEEL
*SURFACE, NAME=TOP
1, S2
*SURFACE, NAME=BOTTOM
2, S1
"""


@pytest.mark.parametrize(
    "contact",
    [
        "*CONTACT PAIR, INTERACTION=I\nBOTTOM, TOP\n*SURFACE INTERACTION, NAME=I\n"
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n1e7\n",
        "*SURFACE INTERACTION, NAME=I\n*CONTACT PAIR, INTERACTION=I, TIED, ADJUST=0.1\nBOTTOM, TOP\n",
        "*SURFACE INTERACTION, NAME=I\n*CONTACT PAIR, INTERACTION=I, TIED, ADJUST=\nBOTTOM, TOP\n",
    ],
)
def test_tied_contact_joins_two_bricks(deck, contact):
    """Of the same frequencies as *TIE; contact that is not tied leaves two parts."""
    tied, tie = deck(TWO_BRICKS + STEEL + contact), deck(TWO_BRICKS + STEEL + "*TIE, NAME=T\nBOTTOM, TOP\n")
    assert list(deck_parts(tied)) == [""]
    np.testing.assert_allclose(deck_frequencies(tied, 9)[6:], deck_frequencies(tie, 9)[6:], rtol=1e-9)
    assert len(deck_parts(deck(TWO_BRICKS + STEEL + contact.replace("TIED", "HARD")))) == 2


# --- nodes that are generated


def test_nodes_on_an_arc_and_a_parabola(deck):
    text = "*NODE\n1, 2, 0, 0\n5, 0, 2, 0\n9, 0, 0, 0\n11, 0, 0, 3\n13, 2, 0, 3\n"
    text += "*NGEN, LINE=C\n1, 5, 1, 9\n*NGEN, LINE=P\n11, 13, 1, , 1, 1, 3\n"
    read = deck(text + "*ELEMENT, TYPE=C3D4\n1, 9, 1, 5, 11\n")
    place = dict(zip(read.node_ids.tolist(), read.nodes, strict=True))
    for k in range(1, 4):
        angle = np.pi / 8 * k
        np.testing.assert_allclose(place[1 + k], [2 * np.cos(angle), 2 * np.sin(angle), 0], atol=1e-14)
    np.testing.assert_allclose(place[12], [1, 1, 3])


@pytest.mark.parametrize(("normal", "angle"), [("0, 0, -2", -270), ("0, 0, 1", 90)])
def test_an_arc_turns_about_its_normal(deck, normal, angle):
    text = f"*NODE\n1, 2, 0, 0\n5, 0, 2, 0\n*NGEN, LINE=C\n1, 5, 1, , 0, 0, 0, {normal}\n"
    read = deck(text + "*ELEMENT, TYPE=T3D2\n1, 1, 5\n")
    place = dict(zip(read.node_ids.tolist(), read.nodes, strict=True))
    for k in range(1, 4):
        phi = np.radians(angle) / 4 * k
        np.testing.assert_allclose(place[1 + k], [2 * np.cos(phi), 2 * np.sin(phi), 0], atol=1e-14)
    with pytest.raises(ImportFormatError, match="have the normal of its plane"):
        deck(text.replace(normal, "1, 0, 1"))


@pytest.mark.parametrize(
    ("system", "option", "point"),
    [
        ("", ", SYSTEM=C", "1, 90, 0"),
        ("0, 1, 0, 1, 2, 0", "", "0, 0, 0"),
        ("0, 0, 0, 0, 1, 0", ", SYSTEM=C", "1, 0, 0"),
    ],
)
def test_the_extra_point_has_the_coordinates_of_its_system(deck, system, option, point):
    """The middle of an arc about (0, 1, 0)."""
    text = "*NODE\n1, 1, 1, 0\n3, 0, 2, 0\n*SYSTEM\n" + (f"{system}\n" if system else "")
    read = deck(text + f"*NGEN, LINE=C{option}\n1, 3, 1, , {point}\n*ELEMENT, TYPE=T3D2\n1, 1, 3\n")
    np.testing.assert_allclose(read.nodes[-1], [0.5**0.5, 1 + 0.5**0.5, 0], atol=1e-14)


def test_half_a_circle_is_refused(deck):
    with pytest.raises(ImportFormatError, match=r"must be less than half a circle.* take two arcs"):
        deck("*NODE\n1, 1, 0, 0\n5, -1, 0, 0\n9, 0, 0, 0\n*NGEN, LINE=C\n1, 5, 1, 9\n")


@pytest.mark.parametrize(
    ("copy", "places"),
    [
        ("SHIFT, MULTIPLE=2\n0, 0, 1\n", {103: [0, 1, 1], 203: [0, 1, 2]}),
        ("SHIFT\n0, 0, 1\n0, 0, 0, 0, 0, 5, 90\n", {102: [0, 1, 1], 103: [-1, 0, 1]}),
        ("SHIFT\n\n0, 0, 0, 0, 0, 5, 90\n", {102: [0, 1, 0], 103: [-1, 0, 0]}),
        ("REFLECT=MIRROR\n0, 0, 1, 1, 0, 1\n0, 1, 1\n", {101: [0, 0, 2], 103: [0, 1, 2]}),
        ("REFLECT=LINE\n0, 0, 0, 0, 0, 1\n", {102: [-1, 0, 0], 104: [0, 0, 1]}),
        ("REFLECT=POINT\n1, 0, 0\n", {102: [1, 0, 0], 103: [2, -1, 0]}),
        ("POLE\n2\n", {101: [-1, 0, 0], 102: [1, 0, 0], 103: [-1, 2, 0]}),
        ("POLE\n, 0, 0, 1\n", {101: [0, 0, -1], 104: [0, 0, 1]}),
    ],
)
def test_copied_nodes(deck, copy, places):
    text = TETRAHEDRON + "*NSET, NSET=ALL\n1, 2, 3, 4\n*NCOPY, CHANGE NUMBER=100, OLD SET=ALL, NEW SET=NEW, "
    read = deck(text + copy + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n")
    found = dict(zip(read.node_ids.tolist(), read.nodes, strict=True))
    for node, place in places.items():
        np.testing.assert_allclose(found[node], place, atol=1e-14)
    assert len(read.node_sets["NEW"]) == len(read.node_ids) - 4


@pytest.mark.parametrize("copy", ["SHIFT\n0, 0, 1\n1, 1, 1, 1, 1, 1, 30\n", "REFLECT=LINE\n", "POLE\n9\n"])
def test_copies_without_an_axis_are_refused(deck, copy):
    text = TETRAHEDRON + "*NSET, NSET=ALL\n1, 2, 3, 4\n*NCOPY, CHANGE NUMBER=100, OLD SET=ALL, "
    with pytest.raises(ImportFormatError, match="NCOPY"):
        deck(text + copy + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n")


# --- elements that bend


@pytest.mark.parametrize("kind", ["C3D8I", "C3D8R"])
def test_a_row_of_hexahedra_bends(deck, kind):
    """Clamped bar of one row of 5 : 1 boxes: f = 1.8751^2 / (2 pi) sqrt(E I / (rho A L^4)) within 1 %."""
    mesh = block(10.0, 0.1, 0.1, 20, 1, 1, CellType.HEXA8)
    text = "*NODE\n" + "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(mesh.nodes, 1))
    text += f"*ELEMENT, TYPE={kind}, ELSET=E\n"
    for i, nodes in enumerate(mesh.cells[CellType.HEXA8] + 1, 1):
        text += ", ".join(map(str, [i, *nodes])) + "\n"
    text += "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1e11, 0.\n*DENSITY\n7800.\n"
    text += "*SOLID SECTION, ELSET=E, MATERIAL=STEEL\n*BOUNDARY\n"
    text += "".join(f"{i + 1}, 1, 3\n" for i in mesh.nodes_of("root"))
    first = 1.8751041**2 / (2 * np.pi) * np.sqrt(2.1e11 * 0.01 / 12 / 7800.0) / 100
    assert deck_frequencies(deck(text), 1, held=True)[0] == pytest.approx(first, rel=0.01)
    assert deck_frequencies(deck(text.replace(kind, "C3D8")), 1, held=True)[0] > 2 * first


@pytest.mark.parametrize(
    "rigid",
    [
        "*ELEMENT, TYPE=C3D4, ELSET=E\n1, 1, 2, 3, 4\n*RIGID BODY, NSET=ALL, REF NODE=9\n"
        "*SOLID SECTION, ELSET=E, MATERIAL=STEEL\n",
        "*ELEMENT, TYPE=MASS, ELSET=M\n1, 9\n*MASS, ELSET=M\n2.5\n",
    ],
)
def test_a_part_that_is_all_rigid_has_no_elastic_modes(deck, rigid):
    read = deck(TETRAHEDRON + "9, 1, 1, 1\n*NSET, NSET=ALL\n1, 2, 3, 4\n" + rigid + STEEL)
    assert not len(deck_frequencies(read, 3))
    np.testing.assert_array_equal(deck_frequencies(read, 3, held=True), 0)
