"""Abaqus and CalculiX input: what is read, and the place and remedy in every error."""

from pathlib import Path

import meshio
import numpy as np
import pytest

from supple.errors import ImportFormatError, MeshError
from supple.importers import UnusedNodes, read_abaqus
from supple.importers.abaqus.mesh_view import read_abaqus_nodes
from supple.mesh import CellType, block
from supple.mesh.reference_cell import reference_nodes

BLADE = Path(__file__).parents[3] / "examples" / "blade.inp"

SQUARE = """\
** a unit square
*HEADING
Made by hand
*NODE, NSET=all
10, 0., 0., 0.
20, 1., 0., 0.
** in the middle of the data
30, 1.D0, 1., 0.
40, 0., 1., 0.
*ELEMENT, TYPE=S3, ELSET=skin
1, 10, 20, 30
2, 10, 30, 40
"""


@pytest.fixture
def read(tmp_path):
    def read_text(text, **options):
        path = tmp_path / "mesh.inp"
        path.write_text(text)
        return read_abaqus(path, **options)

    return read_text


def test_sets_of_surface_elements_are_sets_of_their_nodes(read):
    """As Gmsh writes a solid with named surfaces; a node set keeps its name."""
    cell = "".join(
        f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], 1)
    )
    mesh = read(
        f"*NODE\n{cell}*ELEMENT, TYPE=CPS3, ELSET=Surface1\n1, 1, 2, 3\n*ELEMENT, TYPE=CPS3, ELSET=Surface2\n"
        "2, 1, 2, 4\n*ELEMENT, TYPE=C3D4, ELSET=Volume1\n3, 1, 2, 3, 4\n*ELSET, ELSET=root\n1\n"
        "*ELSET, ELSET=Tip\n2\n*NSET, NSET=TIP\n4\n"
    )
    assert {name: nodes.tolist() for name, nodes in mesh.node_sets.items()} == {
        "TIP": [3],
        "Surface1": [0, 1, 2],
        "Surface2": [0, 1, 3],
        "root": [0, 1, 2],
    }
    assert list(mesh.cell_sets) == ["Volume1"]


def test_plane_stress_elements_alone_are_a_surface(read):
    """As Gmsh writes a surface with a named edge, a truss without a section; no cell has the middle node."""
    places = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5), (0.5, 0.5)]
    nodes = "".join(f"{i}, {x}, {y}, 0\n" for i, (x, y) in enumerate(places, 1))
    edge = "*ELEMENT, TYPE=T3D2, ELSET=Line4\n1, 1, 2\n"
    quad = "*ELEMENT, TYPE=CPS4, ELSET=Surface1\n12, 1, 2, 3, 4\n"
    quad += "*ELSET, ELSET=skin\n12\n*ELSET, ELSET=clamp\n1\n"
    mesh = read("*NODE\n" + "".join(nodes.splitlines(keepends=True)[:4]) + edge + quad)
    assert mesh.cells[CellType.TRIANGLE3].shape == (2, 3)
    assert {name: own.tolist() for name, own in mesh.node_sets.items()} == {"Line4": [0, 1], "clamp": [0, 1]}
    assert sorted(mesh.cell_sets) == ["Surface1", "skin"]
    whole = read(f"*NODE\n{nodes}*ELEMENT, TYPE=M3D9, ELSET=Surface1\n12, 1, 2, 3, 4, 5, 6, 7, 8, 9\n")
    assert whole.n_nodes == 8
    with pytest.raises(ImportFormatError, match="elements of type T3D2 are not part of a mesh"):
        read("*NODE\n" + nodes + edge + quad + "*SOLID SECTION, ELSET=Line4, MATERIAL=m\n1.\n")


# --- what is read


def test_blade():
    mesh = read_abaqus(BLADE)
    assert mesh.n_nodes == 3989
    assert {kind: len(array) for kind, array in mesh.cells.items()} == {CellType.TRIANGLE3: 8394}
    sizes = {name: len(members) for name, members in mesh.node_sets.items()}
    assert sizes == {"NALL": 3989, "ROOT": 28, "TIP": 28, "LE": 125, "TE": 125}
    sizes = {name: len(members[CellType.TRIANGLE3]) for name, members in mesh.cell_sets.items()}
    assert sizes == {"SKIN": 6954, "WEBF": 720, "WEBA": 720, "EALL": 8394}
    assert np.all(mesh.nodes[mesh.nodes_of("ROOT"), 2] == 0)
    assert np.all(np.diff(mesh.nodes[mesh.nodes_of("LE"), 2]) > 0)  # root to tip, as the file lists them


def test_blade_mass():
    """17 740 kg of 0.02 m wall at 1474.9 kg/m^3."""
    mesh = read_abaqus(BLADE)
    a, b, c = np.moveaxis(mesh.nodes[mesh.cells[CellType.TRIANGLE3]], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert 1474.9 * 0.02 * area == pytest.approx(17740, rel=1e-4)


def test_one_web_of_the_blade():
    mesh = read_abaqus(BLADE, only="WEBF")
    whole = read_abaqus(BLADE)
    web = whole.cells[CellType.TRIANGLE3][whole.cells_of("WEBF")[CellType.TRIANGLE3]]
    np.testing.assert_array_equal(mesh.nodes[mesh.cells[CellType.TRIANGLE3]], whole.nodes[web])
    assert set(mesh.node_sets) == {"NALL"}  # no node of the other sets is on it
    assert set(mesh.cell_sets) == {"WEBF", "EALL"}


def test_blade_agrees_with_another_reader():
    mesh, other = read_abaqus(BLADE), meshio.abaqus.read(BLADE)
    np.testing.assert_array_equal(mesh.nodes, other.points)
    np.testing.assert_array_equal(
        mesh.cells[CellType.TRIANGLE3], np.vstack([cells.data for cells in other.cells])
    )
    for name in ("ROOT", "TIP", "LE", "TE"):
        np.testing.assert_array_equal(mesh.nodes_of(name), other.point_sets[name])


@pytest.mark.parametrize("kind", [kind for kind in CellType if kind.n_corners in (4, 8)])
def test_solids_written_by_another_program(kind, tmp_path):
    """Several lines an element, as meshio writes C3D20; the node order is the same on both sides."""
    mesh = block(2.0, 1.0, 1.0, 2, 1, 1, kind)
    path = tmp_path / "block.inp"
    meshio.write(path, meshio.Mesh(mesh.nodes, {kind.meshio_name: mesh.cells[kind]}))
    text = path.read_text().replace("C3D20RH", "C3D20R").replace("C3D8RH", "C3D8R")
    path.write_text(text.replace("C3D10MH", "C3D10").replace("C3D4H", "C3D4"))
    again = read_abaqus(path)
    np.testing.assert_allclose(again.nodes, mesh.nodes)
    np.testing.assert_array_equal(again.cells[kind], mesh.cells[kind])


def test_elements_over_several_lines(read):
    nodes = reference_nodes(CellType.HEXA20)
    lines = [f"{i + 1}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(nodes)]
    first, second = ", ".join(map(str, range(1, 16))), ", ".join(map(str, range(16, 21)))
    text = "\n".join(["*Node", *lines, "*Element, type=c3d20r", f"7, {first},", second])
    np.testing.assert_array_equal(read(text).cells[CellType.HEXA20], [np.arange(20)])


def test_ids_become_numbers_in_the_order_of_the_file(read):
    mesh = read(SQUARE)
    np.testing.assert_array_equal(mesh.nodes, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    np.testing.assert_array_equal(mesh.cells[CellType.TRIANGLE3], [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(mesh.nodes_of("all"), [0, 1, 2, 3])
    np.testing.assert_array_equal(mesh.cells_of("skin")[CellType.TRIANGLE3], [0, 1])


def test_sets_by_list_range_and_name(read):
    mesh = read(
        SQUARE
        + """\
*NSET, NSET=left
40, 10
*NSET, NSET=range, GENERATE
20, 40, 10
10, 10
*NSET, NSET=both
left, 30
RANGE
*NSET, NSET=Left
20
*ELSET, ELSET=second
2,
*ELSET, ELSET=whole
second, skin
"""
    )
    np.testing.assert_array_equal(mesh.nodes_of("left"), [3, 0, 1])  # extended under another spelling
    np.testing.assert_array_equal(mesh.nodes_of("range"), [1, 2, 3, 0])
    np.testing.assert_array_equal(mesh.nodes_of("both"), [3, 0, 2, 1])
    np.testing.assert_array_equal(mesh.cells_of("second")[CellType.TRIANGLE3], [1])
    np.testing.assert_array_equal(mesh.cells_of("whole")[CellType.TRIANGLE3], [0, 1])


def test_blocks_add_up(read):
    """Nodes, elements and one element set in several blocks, of several types."""
    mesh = read(
        SQUARE.replace("30, 1.D0", "*NODE\n30, 1.")
        + "*NODE\n50, 0., 0., 1.\n60, 2., 0., 0.\n"
        + "*ELEMENT, TYPE=C3D4, ELSET=skin\n3, 10, 20, 30, 50\n"
        + "*ELEMENT, TYPE=S3R, ELSET=skin\n4, 20, 60, 30\n"
    )
    assert mesh.n_nodes == 6
    np.testing.assert_array_equal(mesh.cells[CellType.TRIANGLE3][2], [1, 5, 2])
    members = mesh.cells_of("skin")
    np.testing.assert_array_equal(members[CellType.TRIANGLE3], [0, 1, 2])
    np.testing.assert_array_equal(members[CellType.TETRA4], [0])
    np.testing.assert_array_equal(mesh.nodes_of("all"), [0, 1])


def test_four_node_shells_become_two_triangles_along_the_shorter_diagonal(read):
    """A rhombus is cut across; both triangles keep the sense and the sets of the quadrilateral."""
    text = """\
*NODE
1, 0., 0., 0.
2, 2., -0.5, 0.
3, 4., 0., 0.
4, 2., 0.5, 0.
5, 6., 0., 0.
6, 6., 2., 0.
*ELEMENT, TYPE=S4, ELSET=quads
1, 1, 2, 3, 4
*ELEMENT, TYPE=S3
2, 3, 5, 6
*ELSET, ELSET=first
1
"""
    mesh = read(text)
    triangles = mesh.cells[CellType.TRIANGLE3]
    np.testing.assert_array_equal(triangles, [[0, 1, 3], [1, 2, 3], [2, 4, 5]])
    a, b, c = np.moveaxis(mesh.nodes[triangles], 1, 0)
    assert np.all(np.cross(b - a, c - a)[:, 2] > 0)
    for name in ("quads", "first"):
        np.testing.assert_array_equal(mesh.cells_of(name)[CellType.TRIANGLE3], [0, 1])


def test_included_files(tmp_path):
    (tmp_path / "nodes.msh").write_text(SQUARE)
    (tmp_path / "sets.nam").write_text("*NSET, NSET=edge\n10, 20\n")
    deck = tmp_path / "deck.inp"
    deck.write_text("*INCLUDE, INPUT=nodes.msh\n*Include, input=sets.nam\n*STEP\n*END STEP\n")
    np.testing.assert_array_equal(read_abaqus(deck).nodes_of("edge"), [0, 1])


def test_included_files_are_beside_the_main_file_or_the_one_that_includes_them(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "mesh.inp").write_text(
        "*INCLUDE, INPUT=parts\\Nodes.msh\n*INCLUDE, INPUT=sets.nam\n"
    )
    (tmp_path / "parts" / "nodes.msh").write_text(SQUARE)
    (tmp_path / "parts" / "sets.nam").write_text("*NSET, NSET=edge\n10, 20\n")
    (tmp_path / "deck.inp").write_text("*INCLUDE, INPUT=parts/mesh.inp\n")
    np.testing.assert_array_equal(read_abaqus(tmp_path / "deck.inp").nodes_of("edge"), [0, 1])


def test_a_keyword_may_run_over_several_lines(read):
    mesh = read(SQUARE + "*NSET,\nNSET=edge\n10, 20\n")
    np.testing.assert_array_equal(mesh.nodes_of("edge"), [0, 1])


def test_a_single_part_is_read(read):
    text = SQUARE.replace("*NODE", "*PART, NAME=plate\n*NODE", 1) + (
        "*END PART\n*ASSEMBLY, NAME=a\n*INSTANCE, NAME=i, PART=plate\n*END INSTANCE\n"
        "*NSET, NSET=edge, INSTANCE=i\n10, 20\n*END ASSEMBLY\n"
    )
    np.testing.assert_array_equal(read(text).nodes_of("edge"), [0, 1])


# --- nodes that no element uses

REFERENCE = "*NODE, NSET=hub\n99, 5., 5., 5.\n*NSET, NSET=held\n99, 10\n"


def test_unused_nodes_are_refused(read):
    with pytest.raises(MeshError, match=r"mesh.inp: 1 orphan node \(99\).*node 99 is at \(5, 5, 5\)"):
        read(SQUARE + REFERENCE)


def test_unused_nodes_are_dropped_on_request(read):
    mesh = read(SQUARE + REFERENCE, unused_nodes=UnusedNodes.DROP)
    assert mesh.n_nodes == 4
    np.testing.assert_array_equal(mesh.nodes_of("held"), [0])
    assert "hub" not in mesh.node_sets


def test_only_leaves_the_rest_of_the_file_out(read):
    far = (
        "*NODE\n50, 9., 0., 0.\n60, 9., 1., 0.\n70, 8., 0., 0.\n*ELEMENT, TYPE=S3, ELSET=far\n9, 50, 60, 70\n"
    )
    with pytest.raises(MeshError, match="2 disconnected parts"):
        read(SQUARE + far)
    mesh = read(SQUARE + far, only="far")
    np.testing.assert_array_equal(mesh.nodes[:, 0], [9, 9, 8])
    np.testing.assert_array_equal(mesh.cells[CellType.TRIANGLE3], [[0, 1, 2]])


def test_only_names_a_cell_set(read):
    with pytest.raises(
        ImportFormatError, match=r"mesh\.inp: no cell set 'wing' to read; the file has 'skin'"
    ):
        read(SQUARE, only="wing")


# --- errors


def test_missing_file(tmp_path):
    with pytest.raises(ImportFormatError, match=r"absent\.inp: no such file"):
        read_abaqus(tmp_path / "absent.inp")


def test_missing_included_file(read):
    with pytest.raises(
        ImportFormatError, match=r"mesh\.inp, line 1: includes .*nodes\.msh, and there is no such file"
    ):
        read("*INCLUDE, INPUT=nodes.msh\n")


def test_a_file_that_includes_itself(read):
    with pytest.raises(ImportFormatError, match=r"mesh\.inp, line 1: includes nest over 20 deep"):
        read("*INCLUDE, INPUT=mesh.inp\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "mesh.inp: no nodes below a *NODE"),
        ("*NODE\n", "mesh.inp: no nodes below a *NODE"),
        ("1, 0., 0., 0.\n", "mesh.inp, line 1: data before the first *KEYWORD"),
        (SQUARE.partition("*ELEMENT")[0], "mesh.inp: no elements below an *ELEMENT"),
        (SQUARE.partition("1, 10, 20")[0], "mesh.inp, line 10: no elements below *ELEMENT"),
        (SQUARE.partition(", 40\n")[0], "mesh.inp, line 12: an element of type S3 is an id and 3 nodes"),
        (SQUARE.partition("1., 0.\n*ELEMENT")[0], "mesh.inp, line 9: 2 fields; a node is id, x, y, z"),
        (
            SQUARE.replace("1, 10, 20, 30", "1, 10, 20"),
            "mesh.inp, line 11: an element of type S3 is an id and 3",
        ),
        (
            SQUARE.replace("1, 10, 20, 30", "1, 10, 20, 30, 40"),
            "mesh.inp, line 11: an element of type S3 is an id and",
        ),
        (SQUARE.replace("TYPE=S3", "TYPE=X9"), "line 10: unknown element type 'X9'; supported are TYPE=S3"),
        (
            SQUARE.replace("TYPE=S3", "TYPE=B32"),
            "line 10: elements of type B32 are not part of a mesh of surf",
        ),
        (SQUARE.replace("TYPE=S3, ", ""), "line 10: unknown element type ''; supported are TYPE=S3"),
        (
            SQUARE.replace("2, 10, 30, 40", "2, 10, 35, 40"),
            "line 12: element 2 names node 35, which the file",
        ),
        (SQUARE.replace("40, 0.", "10, 0."), "line 9: node 10 is defined a second time; renumber"),
        (SQUARE.replace("2, 10, 30", "1, 10, 30"), "line 12: element 1 is defined a second time; renumber"),
        (SQUARE.replace("20, 1.,", "20, 1.x,"), "line 6: '1.X' is not a number"),
        (SQUARE.replace("2, 10, 30, 40", "2, 10, 30, forty"), "line 12: 'forty' is not a whole number"),
        (SQUARE.replace("20, 1.,", "2.5, 1.,"), "line 6: '2.5' is not a whole number"),
        (SQUARE + "*NSET\n10\n", "line 13: *NSET without a name; write *NSET, NSET=NAME"),
        (SQUARE + "*NSET, NSET=a\n", "line 13: set 'a' is empty"),
        (
            SQUARE + "*NSET, NSET=a\n10, 11\n",
            "line 14: set 'a' names node 11, which the file does not define",
        ),
        (SQUARE + "*ELSET, ELSET=a\n3\n", "line 14: set 'a' names element 3, which the file does not define"),
        (SQUARE + "*NSET, NSET=a\nb\n", "line 14: set 'a' names 'b', neither a node id nor a set above"),
        (SQUARE + "*NSET, NSET=a, GENERATE\n10, 50, 10\n", "line 14: set 'a' names node 50, which"),
        (SQUARE + "*NSET, NSET=a, GENERATE\n10, 999999999999, 10\n", "line 14: set 'a' names node 50, which"),
        (SQUARE + "*NSET, NSET=a, GENERATE\n10\n", "line 14: GENERATE takes first, last, step; got '10'"),
        (
            SQUARE + "*NSET, NSET=a, GENERATE\n40, 10, 10\n",
            "line 14: GENERATE from 40 to 10 by 10 is an empty range",
        ),
        (SQUARE + "*NSET, NSET=a, ELSET=b\n", "line 13: set 'a' names 'b', neither an element id nor a set"),
        (SQUARE.replace("20, 1.,", "20, nan,"), "line 6: 'NAN' is not a number"),
        (SQUARE.replace("20, 1.,", "20, 1_0.,"), "line 6: '1_0.' is not a number"),
        (
            SQUARE.replace("TYPE=S3", "TYPE=S4").replace("1, 10, 20, 30\n2, 10, 30, 40", "1, 10, 30, 20, 40"),
            "line 11: element 1: its sides cross; list its nodes in their order",
        ),
        (
            SQUARE + "*TIE, NAME=t\na, b\n",
            "line 13: *TIE is not part of a mesh, and its absence",
        ),
        (SQUARE + "*Rigid Body, ref node=1\n", "line 13: *RIGID BODY is not part of a mesh"),
        (
            SQUARE + "*SHELL SECTION, ELSET=skin, OFFSET=SPOS\n0.1\n",
            "line 13: *SHELL SECTION, OFFSET is not read; mesh the middle surface",
        ),
        (
            SQUARE + "*NGEN, LINE=A\n10, 40, 10\n",
            "line 13: *NGEN of that kind or with a bias is not supported",
        ),
        (SQUARE + "*NGEN\n10, 45, 10\n", "line 14: *NGEN takes first, last, step; got '10, 45, 10'"),
        (SQUARE + "*NGEN\n10, 45, 5\n", "line 14: *NGEN starts from node 45, which is not above it"),
        (SQUARE + "*NGEN\n10, 30000000, 1\n", "line 14: 29999990 nodes or elements generated by one line"),
        (
            SQUARE + "*NFILL\nall, b, 2\n",
            "line 14: *NFILL takes two sets of equally many nodes, intervals, step",
        ),
        (SQUARE + "*NCOPY, OLD SET=all\n", "line 13: *NCOPY takes CHANGE NUMBER and an OLD SET"),
        (SQUARE + "*ELGEN\n7, 2\n", "line 14: *ELGEN starts from element 7, which is not above it"),
        (SQUARE + "*ELGEN\n1, 2, 5\n", "line 14: *ELGEN makes an element with node 15, which the file does"),
        (SQUARE + "*ELGEN\n1, two\n", "line 14: *ELGEN takes whole numbers; got '1, two'"),
        (
            SQUARE + "*PART, NAME=a\n*END PART\n*INSTANCE, NAME=i, PART=b\n",
            "line 15: an instance of part 'B'",
        ),
        (SQUARE + "*INSTANCE, NAME=a\n1.\n0., 0., 1.\n", "line 15: an instance rotates about the line"),
        (SQUARE + "*NSET, NSET=a, INSTANCE=b\n10\n", "line 13: no instance 'b'; correct its name"),
        (
            SQUARE + "*SYSTEM\n0., 0., 0., 0., 0., 1.\n*NODE\n5, 1.\n",
            "line 13: *SYSTEM: its points give no axes",
        ),
    ],
)
def test_errors_name_file_line_and_remedy(read, text, message):
    with pytest.raises(ImportFormatError) as error:
        read(text)
    assert message in str(error.value)


def test_an_error_in_an_included_file_names_that_file(tmp_path):
    (tmp_path / "bad.msh").write_text("*NODE\n1, 0.\n")
    deck = tmp_path / "deck.inp"
    deck.write_text("** comment\n*INCLUDE, INPUT=bad.msh\n")
    with pytest.raises(ImportFormatError, match=r"bad\.msh, line 2: 2 fields"):
        read_abaqus(deck)


def test_nodes_for_matrices_may_stand_beside_constraints_but_not_turn(tmp_path):
    """Matrices hold what ties and masses do; *TRANSFORM would turn their rows."""
    deck = tmp_path / "deck.inp"
    deck.write_text(SQUARE + "*TIE, NAME=t\na, b\n")
    assert read_abaqus_nodes(deck).ids.tolist() == [10, 20, 30, 40]
    deck.write_text(SQUARE + "*TRANSFORM, NSET=all, TYPE=C\n0., 0., 0., 0., 0., 1.\n")
    with pytest.raises(ImportFormatError, match=r"line 13: \*TRANSFORM rotates the freedoms of its nodes"):
        read_abaqus_nodes(deck)


def test_a_mesh_that_cannot_be_used_names_the_file(read):
    with pytest.raises(MeshError, match=r"mesh\.inp, line 11: element 1: 1 degenerate TRIANGLE3 cell \(1\)"):
        read(SQUARE.replace("20, 1., 0.", "20, 0.5, 0.5"))
