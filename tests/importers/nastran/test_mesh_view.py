"""The mesh alone of Nastran files, and their nodes alone."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from supple.errors import ImportFormatError, MeshError, SuppleWarning
from supple.importers import UnusedNodes, read_mesh, read_nastran, read_nodes
from supple.mesh import CellType, block, strip

SQUARE = """\
GRID,10,,0.,0.,0.
GRID,20,,1.,0.,0.
GRID,30,,1.,1.,0.
GRID,40,,0.,1.,0.
CTRIA3,1,7,10,20,30
CTRIA3,2,7,10,30,40
PSHELL,7,5,0.1,5
MAT1,5,2.1+11,,.3,7850.
"""


@pytest.fixture
def read(tmp_path):
    def read_text(text, **options):
        path = tmp_path / "model.bdf"
        path.write_text(text)
        return read_nastran(path, **options)

    return read_text


@pytest.mark.parametrize(
    "kind", [CellType.TRIANGLE3, *(kind for kind in CellType if kind.n_corners in (4, 8))]
)
def test_meshes_written_by_another_program(tmp_path, kind):
    """meshio writes in its own fields and node orders, without property cards."""
    mesh = strip(2.0, 1.0, 2, 2) if kind is CellType.TRIANGLE3 else block(2.0, 1.0, 1.0, 2, 1, 1, kind)
    cells = [(kind.meshio_name, mesh.cells[kind])]
    groups = {"nastran:ref": [np.ones(len(mesh.cells[kind]), dtype=int)]}
    path = tmp_path / "other.bdf"
    meshio.write(path, meshio.Mesh(mesh.nodes, cells, cell_data=groups))
    again = read_nastran(path)
    np.testing.assert_allclose(again.nodes, mesh.nodes, atol=1e-12)
    np.testing.assert_array_equal(again.cells[kind], mesh.cells[kind])


def test_ids_become_numbers_in_the_order_of_the_file(read):
    model = read(SQUARE)
    np.testing.assert_array_equal(model.node_ids, [10, 20, 30, 40])
    np.testing.assert_array_equal(model.cells[CellType.TRIANGLE3], [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(model.cells_of("pshell_7")[CellType.TRIANGLE3], [0, 1])


def test_quadrilaterals_become_triangles_each_in_the_set_of_its_property(read):
    text = SQUARE.replace(
        "CTRIA3,2,7,10,30,40\n", "GRID,50,,2.,0.,0.\nGRID,60,,2.,1.,0.\nCQUAD4,2,8,20,50,60,30\n"
    )
    mesh = read(text.replace("CTRIA3,1,7,10,20,30", "CQUAD4,1,7,10,20,30,40") + "PSHELL,8,5,.2,5\n")
    assert len(mesh.cells[CellType.TRIANGLE3]) == 4
    np.testing.assert_array_equal(mesh.cells_of("pshell_7")[CellType.TRIANGLE3], [0, 1])
    np.testing.assert_array_equal(mesh.cells_of("pshell_8")[CellType.TRIANGLE3], [2, 3])


def test_a_mesh_without_properties_is_read_by_its_cells_of_the_highest_dimension(tmp_path):
    """A tetrahedron beside a face and an edge of it: these give node sets; blank numbers are one property."""
    path = tmp_path / "plain.bdf"
    tetra = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    meshio.write(path, meshio.Mesh(tetra, [("tetra", np.array([[0, 1, 2, 3]]))]))
    text = path.read_text().replace("ENDDATA", "CTRIA3,2,7,1,2,3\nCBAR,3,8,1,2,0.,0.,1.\nENDDATA")
    path.write_text(text)
    mesh = read_mesh(path)
    assert {kind: cells.tolist() for kind, cells in mesh.cells.items()} == {CellType.TETRA4: [[0, 1, 2, 3]]}
    assert {name: own.tolist() for name, own in mesh.node_sets.items()} == {
        "psolid_9": [0, 1, 2, 3],
        "pshell_7": [0, 1, 2],
        "prod_8": [0, 1],
    }
    assert list(mesh.cell_sets) == ["psolid_9"]
    path.write_text(text.replace("ENDDATA", "MAT1,1,1.,,.3\nENDDATA"))
    with pytest.raises(ImportFormatError, match="needs property and material"):
        read_mesh(path)


def test_the_mesh_of_one_property(tmp_path):
    text = SQUARE + "PSHELL,8,5,.2,5\nGRID,50,,2.,0.,0.\nCTRIA3,3,8,20,50,30\n"
    (tmp_path / "model.nas").write_text(text)
    mesh = read_mesh(tmp_path / "model.nas", only="pshell_8")
    np.testing.assert_array_equal(mesh.nodes, [[1, 0, 0], [1, 1, 0], [2, 0, 0]])


def test_supports_and_the_analysis_set_are_node_sets(read):
    text = SQUARE.replace("GRID,40,,0.,1.,0.", "GRID,40,,0.,1.,0.,,3")
    text += "SPC1,1,123456,10,20\nSPC,2,30,21,0.,40,12,0.\nSPC1,1,123456,30,THRU,45\n"
    text += "ASET1,123,10,THRU,20\nASET,40,4\n"
    sets = {name: members.tolist() for name, members in read(text).node_sets.items()}
    assert sets == {"spc_3": [3], "spc2_12": [2, 3], "spc1_123456": [0, 1, 2, 3], "aset": [0, 1, 3]}


def test_the_freedoms_of_an_analysis_set_are_sorted_as_nastran_does(tmp_path):
    (tmp_path / "model.bdf").write_text(SQUARE + "ASET1,31,30,10\nASET,20,4\n")
    retained = read_nodes(tmp_path / "model.bdf").retained
    assert retained is not None
    assert retained.tolist() == [[10, 1], [10, 3], [20, 4], [30, 1], [30, 3]]


def test_unused_grids_can_be_dropped(read):
    model = read("GRID,5,,9.,9.,9.\n" + SQUARE + "SPC1,1,123,5\n", unused_nodes=UnusedNodes.DROP)
    np.testing.assert_array_equal(model.node_ids, [10, 20, 30, 40])
    np.testing.assert_array_equal(model.cells[CellType.TRIANGLE3], [[0, 1, 2], [0, 2, 3]])
    assert not model.node_sets


def test_nodes_for_matrices_stand_beside_elements_of_any_kind(tmp_path):
    text = SQUARE + "CBUSH,9,3,10,20\nCONM2,12,,30,5.\nGRID,90,,5.,0.,0.\nRBE3,70,,90,123456,1.,123,20,30\n"
    (tmp_path / "model.bdf").write_text(text)
    table = read_nodes(tmp_path / "model.bdf")
    np.testing.assert_array_equal(table.ids, [10, 20, 30, 40, 90])
    np.testing.assert_array_equal(table.node_sets["rbe3_70"], [1, 2])
    assert table.axes is None


def test_a_truncated_file_is_recognised(read, bulk):
    whole = bulk.text(block(1, 1, 1, 1, 1, 1, CellType.HEXA8), *bulk.solid())
    with pytest.raises(
        ImportFormatError, match=r"no elements that are cells; is this a mesh file, and complete\?"
    ):
        read(whole[: len(whole) // 2])


def test_an_element_without_volume_is_named_with_its_line(read):
    tetra = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,1.,1.,0.\n"
    tetra += "CTETRA,1,3,1,2,3,4\nPSOLID,3,5\n"
    with pytest.raises(MeshError, match=r"model\.bdf, line 5: element 1: 1 degenerate TETRA4 cell"):
        read(tetra + "MAT1,5,1.,,.3\n")
    flat = SQUARE.replace("GRID,40,,0.,1.,0.", "GRID,40,,.5,.5,0.")
    with pytest.raises(MeshError, match=r"model\.bdf, line 6: element 2: 1 degenerate TRIANGLE3"):
        read(flat)


def test_a_mesh_with_holes_is_refused(read):
    with pytest.raises(ImportFormatError, match=r"line 6: CTRIA3: 1 elements .*property 8.* add the cards"):
        read(SQUARE.replace("CTRIA3,2,7", "CTRIA3,2,8"))


@pytest.mark.parametrize(
    ("cards", "message"),
    [
        (
            "INCLUDE 'rest.bdf'\n",
            r"line 9: INCLUDE: there is no file .*rest\.bdf: .* may have holes: add the",
        ),
        ("CBEAM3,3,9,10,20,30\n", "line 9: CBEAM3: 1 curved beams .*; without them the mesh has holes"),
        ("CTRIAX6,3,9,10,20,30\n", "line 9: CTRIAX6: 1 axisymmetric solids; without them"),
        ("SEBULK,4,EXTOP4\n", "SEBULK: superelement 4 is in another file"),
    ],
)
def test_elements_that_are_not_read_are_holes(read, cards, message):
    part = "BEGIN SUPER=3\n" + SQUARE if cards.startswith("SEBULK") else ""
    with pytest.raises(ImportFormatError, match=message):
        read(("BEGIN BULK\n" if part else "") + SQUARE + cards + part)


def test_a_mesh_without_its_connections_is_doubtful(read):
    with pytest.warns(SuppleWarning, match="line 9: CWELD: 1 spot welds: the parts they join"):
        mesh = read(SQUARE + "CWELD,3,9,10\n")
    assert len(mesh.cells[CellType.TRIANGLE3]) == 2
    assert len(read("CEND\nINCLUDE 'case.inc'\nBEGIN BULK\n" + SQUARE).nodes) == 4


def test_reference_grids_of_ties_are_no_nodes_of_a_mesh(read):
    mesh = read(SQUARE + "GRID,90,,5.,0.,0.\nRBE2,70,90,123456,20,30\n")
    np.testing.assert_array_equal(mesh.node_ids, [10, 20, 30, 40])
    np.testing.assert_array_equal(mesh.nodes_of("rbe2_70"), [1, 2])
    with pytest.raises(MeshError, match="1 orphan node"):
        read(SQUARE + "GRID,90,,5.,0.,0.\n")


def test_ties_are_places_for_joints(tmp_path):
    """Of nodes for matrices: the reference moves with the others unless it is a mean of further ones."""
    text = SQUARE + "GRID,90,,5.,0.,0.\nRBE2,70,90,123456,20,30\nGRID,91,,-1.,0.,0.\n"
    text += "RBE3,71,,91,123456,1.0,123,10\n,40,3.,123,20,ALPHA,6.5-6\nRBE2,72,91,123456,40,6.5-6\n"
    (tmp_path / "model.bdf").write_text(text)
    rigid, other, averaging = read_nodes(tmp_path / "model.bdf").connections
    assert (rigid.name, other.name, averaging.name) == ("rbe2_70", "rbe2_72", "rbe3_71")
    np.testing.assert_array_equal(rigid.nodes, [4, 1, 2])
    np.testing.assert_array_equal(rigid.position, [5, 0, 0])
    np.testing.assert_array_equal(other.nodes, [3])
    np.testing.assert_array_equal(averaging.nodes, [0, 3, 1])
    np.testing.assert_array_equal(averaging.weights, [1, 1, 3])
