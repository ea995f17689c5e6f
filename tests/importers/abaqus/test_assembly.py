"""Parts, instances and generated meshes of Abaqus decks, beside flat decks of the same body."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.abaqus_decks import STEEL, brick, element_rows, node_rows

from supple.body import deck_frequencies
from supple.errors import ImportFormatError
from supple.importers import UnusedNodes, read_abaqus
from supple.mesh import CellType
from supple.mesh.reference_cell import reference_nodes

NODES, CELLS = brick((0.2, 0.1, 0.1), (2, 1, 1))
PART = (
    "*PART, NAME=block\n"
    + node_rows(NODES)
    + element_rows("C3D8", CELLS)
    + "*NSET, NSET=root\n1, 2, 3, 4\n*ELSET, ELSET=last\n2\n"
    + "*SURFACE, NAME=tip\nlast, S4\n*SURFACE, NAME=foot\n1, S6\n"
    + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n*END PART\n"
)
TIE = "*TIE, NAME=t\nb.foot, a.tip\n"


def assembly(second="0.2, 0., 0.\n", more="", after=TIE):
    """Two instances of the part, the second one moved, and what the model says."""
    text = PART + "*ASSEMBLY, NAME=model\n*INSTANCE, NAME=a, PART=block\n*END INSTANCE\n"
    text += f"*INSTANCE, NAME=b, PART=block\n{second}*END INSTANCE\n"
    return (
        text
        + f"*NSET, NSET=held, INSTANCE=a\nroot\n{more}{after}*END ASSEMBLY\n{STEEL}*BOUNDARY\nheld, 1, 3\n"
    )


def flat():
    nodes, cells = brick((0.4, 0.1, 0.1), (4, 1, 1))
    text = (
        node_rows(nodes) + element_rows("C3D8", cells) + STEEL + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n"
    )
    return text + "*NSET, NSET=held\n1, 2, 3, 4\n*BOUNDARY\nheld, 1, 3\n"


def test_two_instances_make_one_body(deck):
    made = deck(assembly())
    assert made.left_out == ()
    np.testing.assert_allclose(
        deck_frequencies(made, 4, held=True), deck_frequencies(deck(flat()), 4, held=True), rtol=1e-9
    )


def test_an_instance_turns_about_its_axis(deck):
    """Half a turn about the middle of the joint: its foot faces away, and its tip is tied instead."""
    turned = assembly(
        "0.2, 0., 0.\n0.3, 0.05, 0., 0.3, 0.05, 1., 180.\n", after="*TIE, NAME=t\nb.tip, a.tip\n"
    )
    made = deck(turned)
    assert made.nodes[:, 0].max() == pytest.approx(0.4)
    foot = made.nodes[made.node_sets["b.foot"]]
    np.testing.assert_allclose(foot[:, 0], 0.4)
    np.testing.assert_allclose(
        deck_frequencies(made, 4, held=True), deck_frequencies(deck(flat()), 4, held=True), rtol=1e-9
    )


def test_a_quarter_turn_is_right_handed(deck):
    made = deck(assembly("0., 0., 0.\n0., 0., 0., 0., 0., 1., 90.\n", after=""))
    second = made.nodes[12:]
    np.testing.assert_allclose(second, np.column_stack([-NODES[:, 1], NODES[:, 0], NODES[:, 2]]), atol=1e-12)


def test_an_instance_without_a_translation_turns(deck):
    made = deck(assembly("\n0., 0., 0., 0., 0., 1., 90.\n", after=""))
    second = made.nodes[12:]
    np.testing.assert_allclose(second, np.column_stack([-NODES[:, 1], NODES[:, 0], NODES[:, 2]]), atol=1e-12)


def test_elements_of_the_assembly_name_nodes_of_instances(deck):
    """As Abaqus/CAE writes springs between instances, and masses on one of them."""
    more = "*ELEMENT, TYPE=SPRINGA, ELSET=s\n1, a.4, B.7\n2, 1, b.2\n*SPRING, ELSET=s\n\n2.\n"
    more += "*ELEMENT, TYPE=MASS, ELSET=m\n3, a.5\n*MASS, ELSET=m\n3.\n*NODE\n1, 1., 0., 0.\n"
    made = deck(assembly(after="", more=more))
    springs, masses = made.springs[0], made.inertias[0]
    ends = [set((springs.freedoms[springs.rows == row] // 6).tolist()) for row in (0, 1)]
    n = len(NODES)
    assert ends == [{3, n + 6}, {2 * n, n + 1}]
    assert set((masses.freedoms // 6).tolist()) == {4}
    with pytest.raises(ImportFormatError, match=r"'c\.5' is not a whole number"):
        deck(assembly(after="", more=more.replace("a.5", "c.5")))


def test_a_system_of_nodes_belongs_to_its_part(deck):
    other = "*PART, NAME=other\n*NODE\n1, 1., 0., 0.\n*END PART\n*ASSEMBLY"
    text = assembly(after="", more="*NODE\n1, 1., 0., 0.\n").replace("*NODE", "*SYSTEM\n0., 0., 2.\n*NODE", 1)
    text = text.replace("*ASSEMBLY", other, 1).replace(
        "*INSTANCE, NAME=b", "*INSTANCE, NAME=c, PART=other\n*END INSTANCE\n*INSTANCE, NAME=b"
    )
    made = deck(text)
    np.testing.assert_allclose(made.nodes[:12], NODES + np.array([0, 0, 2]))
    np.testing.assert_allclose(made.nodes[12], [1, 0, 0])
    np.testing.assert_allclose(made.nodes[-1], [1, 0, 0])


def test_names_and_ids_of_instances(deck):
    """Where ids repeat, those of the second instance are raised by a power of ten."""
    made = deck(assembly(more="*NODE\n1, 9., 9., 9.\n*NSET, NSET=point\n1\n"))
    assert {"held", "a.root", "b.root", "a.tip", "b.foot", "point"} <= set(made.node_sets)
    assert {"a.all", "b.all", "a.last", "b.last"} <= set(made.element_sets)
    ids = made.node_ids[made.node_sets["b.root"]]
    np.testing.assert_array_equal(ids, [101, 102, 103, 104])
    np.testing.assert_array_equal(made.node_ids[made.node_sets["a.root"]], [1, 2, 3, 4])
    np.testing.assert_array_equal(made.node_ids[made.node_sets["point"]], [201])
    np.testing.assert_array_equal(made.element_sets["b.last"], [12])
    assert (
        "instances use the same ids: those of the second are raised by 100, the third by 200, .."
        in made.notes
    )
    np.testing.assert_allclose(made.nodes[made.node_sets["held"]][:, 0], 0)


def test_each_instance_is_a_body_too(deck):
    coupling = "*NODE\n1, 0.5, 0.05, 0.05\n*NSET, NSET=point\n1\n"
    coupling += "*COUPLING, CONSTRAINT NAME=hub, REF NODE=point, SURFACE=b.tip\n*KINEMATIC\n"
    made = deck(assembly(more=coupling))
    first, second = made.superelements["a"], made.superelements["b"]
    assert len(first.node_ids) == 12
    assert len(second.node_ids) == 13  # with the reference of its coupling
    assert {"root", "held"} <= set(first.node_sets)
    assert "b.root" not in first.node_sets
    assert second.element_sets["last"].tolist() == [12]
    assert second.constraints == first.constraints == ()
    assert [tie.name for tie in second.rigid] == ["hub"]
    np.testing.assert_allclose(second.nodes[second.rigid[0].reference], [0.5, 0.05, 0.05])
    assert second.notes[-1] == (
        "12 constraints or springs join instance 'b' to others; between bodies, use joints instead"
    )
    assert len(first.held[0].lines) == 12
    assert second.held == ()
    alone = node_rows(NODES) + element_rows("C3D8", CELLS) + STEEL
    whole = deck(alone + "*SOLID SECTION, ELSET=all, MATERIAL=steel\n")
    np.testing.assert_allclose(deck_frequencies(first, 3), deck_frequencies(whole, 3), rtol=1e-9)


def test_one_instance_keeps_plain_names(deck):
    text = PART + "*ASSEMBLY, NAME=m\n*INSTANCE, NAME=a, PART=block\n*END INSTANCE\n"
    text += "*NSET, NSET=root, INSTANCE=a\n5\n*NSET, NSET=end, INSTANCE=a\n9, 10\n*END ASSEMBLY\n"
    made = deck(text + STEEL + "*BOUNDARY\na.root, 3\na.12, 2\nend, 1\n")
    assert made.superelements == {}
    np.testing.assert_array_equal(made.node_sets["root"], [4])
    np.testing.assert_array_equal(made.node_sets["a.root"], [0, 1, 2, 3])
    assert [term // 6 for term in made.held[0].freedoms.tolist()] == [0, 1, 2, 3, 11, 8, 9]


def test_parts_without_instances_are_read(deck):
    made = deck(PART + STEEL)
    np.testing.assert_allclose(made.nodes, NODES)
    assert made.left_out == ()


def test_a_part_without_an_instance_of_it_is_named(deck):
    made = deck(
        assembly().replace("*ASSEMBLY", "*PART, NAME=spare\n*NODE\n1, 0., 0., 0.\n*END PART\n*ASSEMBLY")
    )
    assert "part 'spare' has no instance and is not read" in made.notes


def test_an_instance_of_another_analysis_is_left_out(deck):
    made = deck(assembly().replace("*INSTANCE, NAME=b, PART=block", "*INSTANCE, LIBRARY=old, INSTANCE=x"))
    assert made.left_out[0].meaning == "this instance of another analysis is not read"


def test_the_mesh_of_an_assembly(tmp_path):
    """Meshes have no ties: two instances that share no node are two parts."""
    (tmp_path / "m.inp").write_text(assembly(after="").replace("*SURFACE, NAME=foot\n1, S6\n", ""))
    mesh = read_abaqus(tmp_path / "m.inp", only="b.all")
    assert mesh.nodes[:, 0].min() == pytest.approx(0.2)
    np.testing.assert_array_equal(mesh.node_ids[:4], [101, 102, 103, 104])
    assert mesh.nodes_of("b.root").tolist() == [0, 1, 2, 3]


# --- generated meshes


def test_generated_nodes_and_elements_are_the_written_ones(tmp_path):
    text = (
        "*NODE, NSET=low\n1, 0., 0., 0.\n5, 4., 0., 0.\n*NGEN, NSET=low\n1, 5, 1\n"
        "*NODE\n21, 0., 2., 0.\n25, 4., 2., 0.\n*NGEN, NSET=high\n21, 25\n"
        "*NFILL, NSET=every\nlow, high, 2, 10\n"
        "*ELEMENT, TYPE=S4, ELSET=skin\n1, 1, 2, 12, 11\n*ELGEN, ELSET=skin\n1, 4, 1, 1, 2, 10, 4\n"
    )
    (tmp_path / "m.inp").write_text(text)
    mesh = read_abaqus(tmp_path / "m.inp", unused_nodes=UnusedNodes.DROP)
    x, y = np.meshgrid(np.arange(5.0), np.arange(3.0))
    order = np.argsort(mesh.node_ids)
    np.testing.assert_array_equal(
        mesh.node_ids[order], (1 + np.arange(5) + 10 * np.arange(3)[:, None]).ravel()
    )
    np.testing.assert_allclose(mesh.nodes[order], np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]))
    (cells,) = mesh.cells.values()
    a, b, c = np.moveaxis(mesh.nodes[cells], 1, 0)
    assert np.cross(b - a, c - a)[:, 2].sum() / 2 == pytest.approx(8)
    (ids,) = mesh.cell_ids.values()
    np.testing.assert_array_equal(ids, np.repeat(np.arange(1, 9), 2))
    assert len(mesh.nodes_of("low")) == 5


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("*NODE, SYSTEM=C\n1, 2., 90., 3.\n", [0, 2, 3]),
        ("*NODE, SYSTEM=S\n1, 2., 90., 30.\n", [0, 3**0.5, 1]),
        ("*SYSTEM\n1., 0., 0., 1., 1., 0.\n*NODE\n1, 2., 1., 3.\n", [0, 2, 3]),
        ("*SYSTEM\n1., 0., 0., 1., 1., 0.,\n1., 0., 1.\n*NODE\n1, 2., 1., 3.\n", [4, 2, 1]),
        ("*SYSTEM\n2., 0., 2.\n*NODE\n1, 2., 1., 3.\n", [4, 1, 5]),
        ("*SYSTEM\n0., 0., 0.\n*NODE\n1, 2., 1., 3.\n", [2, 1, 3]),
        ("*SYSTEM\n1., 0., 0., 1., 1., 7.\n*NODE\n1, 2., 1., 3.\n", [0, 2, 3]),
        ("*NODE\n1, 2.\n", [2, 0, 0]),
        ("*NODE\n1, 2., , 3.\n", [2, 0, 3]),
        ("*NODE\n1, 2., 1., 3., 0., 0., 1.\n", [2, 1, 3]),
    ],
)
def test_coordinates_of_nodes(deck, text, place):
    made = deck(text + "*ELEMENT, TYPE=MASS, ELSET=m\n1, 1\n*MASS, ELSET=m\n1.\n")
    np.testing.assert_allclose(made.nodes, [place], atol=1e-12)


ROW = "*NODE, NSET=row\n1, 0., 0., 0.\n5, 4., 0., 0.\n*NGEN, NSET=row\n1, 5\n"


def test_an_element_set_of_generated_elements_has_their_master(deck):
    text = ROW + "*ELEMENT, TYPE=T3D2\n1, 1, 2\n*ELGEN, ELSET=every\n1, 4\n" + STEEL
    made = deck(text + "*SOLID SECTION, ELSET=every, MATERIAL=steel\n1e-4\n")
    assert made.left_out == ()
    assert made.element_sets["every"].tolist() == [1, 2, 3, 4]
    copy = "*NCOPY, OLD SET=row, CHANGE NUMBER=10, SHIFT\n0., 1., 0.\n"
    copy += "*ELCOPY, OLD SET=every, ELEMENT SHIFT=10, SHIFT NODES=10, NEW SET=copies\n"
    made = deck(text + copy + "*SOLID SECTION, ELSET=every, MATERIAL=steel\n1e-4\n")
    assert sorted(made.element_sets["copies"].tolist()) == [11, 12, 13, 14]


def test_generated_beams_keep_the_node_of_their_first_axis(deck):
    text = ROW + "*NODE\n9, 0., 5., 0.\n19, 0., 0., 5.\n*ELEMENT, TYPE=B31, ELSET=all\n1, 1, 2, 9\n"
    with pytest.raises(ImportFormatError, match="element 1, a beam with a node for its first axis"):
        deck(text + "*ELGEN, ELSET=all\n1, 4\n")
    text += "*NSET, NSET=old\n1, 2\n*NCOPY, OLD SET=old, CHANGE NUMBER=10, SHIFT\n0., 0., 0.\n"
    copy = "*ELCOPY, OLD SET=all, ELEMENT SHIFT=10, SHIFT NODES=10, NEW SET=all\n"
    section = STEEL + "*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=CIRC\n0.1\n"
    made = deck(text + copy + section)
    np.testing.assert_allclose(made.elements[1].directions, [[0, 0, 1]], atol=1e-12)
    with pytest.raises(ImportFormatError, match="makes an element with node 19"):
        deck(text.replace("19, 0., 0., 5.\n", "") + copy + section)


@pytest.mark.parametrize(
    ("options", "members", "pairs"),
    [
        ("", "15, 12, 13, 14, 11", [(1, 11), (2, 12), (3, 13), (4, 14), (5, 15)]),
        (", UNSORTED", "15, 12, 13, 14, 11", [(1, 15), (2, 12), (3, 13), (4, 14), (5, 11)]),
        (", GENERATE", "11, 15", [(1, 11), (2, 12), (3, 13), (4, 14), (5, 15)]),
    ],
)
def test_nodes_of_two_sets_are_paired_in_the_order_of_their_ids(deck, options, members, pairs):
    """Unless a set is unsorted; a set of generated nodes is sorted, too."""
    text = ROW.replace(", NSET=row\n1", "\n1", 1) + "*ELEMENT, TYPE=T3D2\n1, 1, 2\n"
    text += "*NODE\n" + "".join(f"{11 + i}, {i}., 1., 0.\n" for i in range(5))
    text += f"*NSET, NSET=other{options}\n{members}\n"
    made = deck(text + "*EQUATION\n2\nrow, 1, 1., other, 1, -1.\n*MPC\nPIN, row, other\n")
    (terms,) = made.constraints
    found = (
        made.node_ids[terms.freedoms[terms.factors > 0] // 6],
        made.node_ids[terms.freedoms[terms.factors < 0] // 6],
    )
    assert list(zip(*(each.tolist() for each in found), strict=True)) == [
        *pairs,
        *(pair for pair in pairs for _ in "xyz"),
    ]
    assert made.node_ids[made.node_sets["row"]].tolist() == [1, 2, 3, 4, 5]


def test_lines_between_unsorted_sets(deck):
    text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n21, 0., 2., 0.\n22, 1., 2., 0.\n"
    text += "*NSET, NSET=low, UNSORTED\n2, 1\n*NSET, NSET=high, UNSORTED\n22\n*NSET, NSET=high\n21\n"
    text += "*NFILL, NSET=every\nlow, high, 2, 10\n*ELEMENT, TYPE=T3D2\n1, 1, 2\n"
    made = deck(text)
    place = dict(zip(made.node_ids.tolist(), made.nodes.tolist(), strict=True))
    assert (place[12], place[11]) == ([1, 1, 0], [0, 1, 0])


# --- surfaces and sets

FACES = {
    "S1": [0, 2, 4, 6], "S2": [1, 3, 5, 7], "S3": [0, 1, 4, 5], "S4": [4, 5, 6, 7], "S5": [2, 3, 6, 7],
    "S6": [0, 1, 2, 3],
}  # fmt: skip


@pytest.mark.parametrize("label", FACES)
def test_faces_of_a_hexahedron(deck, label):
    nodes, cells = brick((1, 1, 1), (1, 1, 1))
    made = deck(node_rows(nodes) + element_rows("C3D8", cells) + f"*SURFACE, NAME=face\nall, {label}\n")
    assert sorted(made.node_sets["face"].tolist()) == FACES[label]


def test_faces_have_their_middle_nodes(deck):
    for name, kind, label, normal in (
        ("C3D20", CellType.HEXA20, "S4", (1, 0, 0)), ("C3D10", CellType.TETRA10, "S2", (0, -1, 0)),
        ("C3D15", CellType.WEDGE15, "S2", (0, 0, 1)), ("C3D13", CellType.PYRAMID13, "S1", (0, 0, -1)),
    ):  # fmt: skip
        nodes = reference_nodes(kind)
        cells = [np.arange(kind.n_nodes)]
        made = deck(node_rows(nodes) + element_rows(name, cells) + f"*SURFACE, NAME=face\nall, {label}\n")
        far = nodes @ normal
        assert sorted(made.node_sets["face"].tolist()) == np.flatnonzero(np.isclose(far, far.max())).tolist()


def test_a_surface_without_labels_is_the_free_faces(deck):
    made = deck(
        node_rows(brick((2, 2, 2), (2, 2, 2))[0])
        + element_rows("C3D8", brick((2, 2, 2), (2, 2, 2))[1])
        + "*SURFACE, NAME=skin\nall,\n"
    )
    assert sorted(made.node_sets["skin"].tolist()) == [i for i in range(27) if i != 13]


def test_the_free_faces_of_a_set_are_those_of_the_body(deck):
    """Also of a set over several keywords, beside other elements, and beside a collapsed hexahedron."""
    nodes, cells = brick((3, 1, 1), (3, 1, 1))
    row = cells[2][[0, 1, 1, 3, 4, 5, 5, 7]]
    text = (
        node_rows(nodes)
        + element_rows("C3D8", cells[:1], "first")
        + element_rows("C3D8R", cells[1:2], "second", 2)
    )
    text += element_rows("C3D8", [row], "last", 3) + "*ELSET, ELSET=two\nfirst, second\n"
    text += "*SURFACE, NAME=skin\ntwo,\n*SURFACE, NAME=middle\nsecond,\n*SURFACE, NAME=tip\nlast,\n"
    text += "*NODE\n99, 9., 9., 9.\n"
    made = deck(
        text
        + "".join(
            f"*COUPLING, REF NODE=99, SURFACE={name}\n*DISTRIBUTING\n" for name in ("skin", "middle", "tip")
        )
    )
    assert [mean.weights.sum() for mean in made.means] == pytest.approx([9, 4, 1 + 1 + np.sqrt(2)])


@pytest.mark.parametrize(("kind", "nodes"), [("B31", [1, 2]), ("B32", [1, 2, 3]), ("T3D3", [1, 2, 3])])
def test_the_ends_of_beams_are_surfaces(deck, kind, nodes):
    text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n"
    text += f"*ELEMENT, TYPE={kind}, ELSET=all\n1, {', '.join(map(str, nodes))}\n"
    made = deck(text + "*SURFACE, NAME=a\nall, END1\n*SURFACE, NAME=b\nall, END2\n*SURFACE, NAME=c\nall,\n")
    assert [made.node_ids[made.node_sets[name]].tolist() for name in "abc"] == [[1], [nodes[-1]], nodes]


def test_surfaces_of_shells_and_nodes(deck):
    text = node_rows(brick((1, 1, 0), (1, 1, 1))[0][::2]) + element_rows("S4", [[0, 2, 3, 1]])
    sets = "*NSET, NSET=n\n2, 3\n"
    sets += (
        "*SURFACE, NAME=all_of_it\nall, SPOS\n*SURFACE, NAME=edge\nall, E2\n*SURFACE, NAME=same\nall, S4\n"
    )
    made = deck(text + sets + "*SURFACE, NAME=points, TYPE=NODE\nn, 1.\n4\n*SURFACE, NAME=n, TYPE=NODE\n1\n")
    assert sorted(made.node_sets["all_of_it"].tolist()) == [0, 1, 2, 3]
    assert made.node_sets["edge"].tolist() == made.node_sets["same"].tolist() == [2, 3]
    assert made.node_sets["points"].tolist() == [1, 2, 3]
    assert made.node_sets["n"].tolist() == [1, 2]
    assert made.node_sets["surface n"].tolist() == [0]


def test_sets_of_the_nodes_of_elements(deck):
    text = (
        node_rows(NODES) + element_rows("C3D8", CELLS) + "*ELSET, ELSET=last\n2\n*NSET, NSET=n, ELSET=last\n"
    )
    assert deck(text).node_sets["n"].tolist() == list(range(4, 12))


def test_unknown_members_of_sets_are_noted(deck):
    text = (
        node_rows(NODES)
        + element_rows("C3D8", CELLS)
        + "*NSET, NSET=n, GENERATE\n10, 20\n*NSET, NSET=m\n1, 99, x\n"
    )
    made = deck(text)
    assert made.node_sets["n"].tolist() == [9, 10, 11]
    assert made.node_sets["m"].tolist() == [0]
    assert len(made.notes) == 3
    assert "set 'n' names node 13, which the file does not define" in made.notes[0]


def test_the_last_definition_of_an_id_holds(deck):
    text = node_rows(NODES) + "*NODE\n12, 0.3, 0.1, 0.1\n" + element_rows("C3D8", CELLS)
    made = deck(
        text + element_rows("C3D8", [CELLS[1]], elset="new") + "*ELEMENT, TYPE=S3, ELSET=skin\n2, 1, 2, 3\n"
    )
    assert made.nodes[-1].tolist() == [0.3, 0.1, 0.1]
    assert len(made.nodes) == 12
    assert [note.split(": ")[-1] for note in made.notes] == [
        "node 12 is defined a second time; renumber or remove it",
        "element 1 is defined a second time; renumber or remove it",
    ]
    assert {name: of.tolist() for name, of in made.element_sets.items()} == {
        "all": [],
        "new": [1],
        "skin": [2],
    }


def test_titles_above_the_first_keyword_are_passed_over(deck):
    assert len(deck(">** a title\n" + node_rows(NODES) + element_rows("C3D8", CELLS)).nodes) == 12
