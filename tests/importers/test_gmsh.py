"""Gmsh files: formats 2 and 4, text and binary, tell the same mesh; errors name file, place and remedy.

The files in gmsh_square were written by Gmsh 4.15: a plate 2 by 1 of four triangles, in the physical surfaces
'skin' and 'whole plate', with the physical curve 'root' at x = 0, an unnamed one (tag 7) at x = 2, and the
physical point 'corner' at (2, 1, 0).
"""

from pathlib import Path

import meshio
import numpy as np
import pytest
from fixtures.solid_blocks import LINEAR, solid_block

from supple.errors import ImportFormatError, MeshError
from supple.importers import UnusedNodes, read_gmsh
from supple.mesh import CellType, block
from supple.mesh.reference_cell import reference_nodes

SQUARES = Path(__file__).parent / "gmsh_square"
FORMATS = sorted(SQUARES.glob("*.msh"), key=lambda path: path.name)
TEXT_2, TEXT_4 = SQUARES / "format_2_text.msh", SQUARES / "format_4_text.msh"


@pytest.fixture
def changed(tmp_path):
    """Copy of a text file with one piece replaced."""

    def write(path, old, new):
        text = path.read_text()
        assert old in text
        copy = tmp_path / path.name
        copy.write_text(text.replace(old, new))
        return copy

    return write


# --- what is read


def test_four_files():
    assert len(FORMATS) == 4


@pytest.mark.parametrize("path", FORMATS, ids=lambda path: path.stem)
def test_nodes_and_cells(path):
    mesh = read_gmsh(path)
    assert mesh.n_nodes == 6
    assert mesh.n_cells == 4  # format 2 writes each triangle twice, once a group
    a, b, c = np.moveaxis(mesh.nodes[mesh.cells[CellType.TRIANGLE3]], 1, 0)
    areas = np.cross(b - a, c - a) / 2
    np.testing.assert_allclose(areas, np.tile([0, 0, 0.5], (4, 1)), atol=1e-10)


@pytest.mark.parametrize("path", FORMATS, ids=lambda path: path.stem)
def test_physical_groups(path):
    mesh = read_gmsh(path)
    assert set(mesh.node_sets) == {"corner", "root", "curve 7", "skin", "whole plate"}
    np.testing.assert_array_equal(mesh.nodes[mesh.nodes_of("corner")], [[2, 1, 0]])
    np.testing.assert_array_equal(np.flatnonzero(mesh.nodes[:, 0] == 0), mesh.nodes_of("root"))
    np.testing.assert_array_equal(np.flatnonzero(mesh.nodes[:, 0] == 2), mesh.nodes_of("curve 7"))
    assert set(mesh.cell_sets) == {"skin", "whole plate"}
    for name in mesh.cell_sets:
        np.testing.assert_array_equal(mesh.cells_of(name)[CellType.TRIANGLE3], np.arange(4))


# Meshio writes no wedge15 and no pyramid13; below they stand by their numbers.
@pytest.mark.parametrize("kind", [*LINEAR, CellType.TETRA10, CellType.HEXA20])
@pytest.mark.parametrize("file_format", ["gmsh22", "gmsh"])
@pytest.mark.parametrize("binary", [False, True])
def test_solids(kind, file_format, binary, tmp_path):
    mesh = solid_block(2.0, 1.0, 1.0, 2, 1, 1, kind)
    path = tmp_path / "block.msh"
    meshio.write(
        path, meshio.Mesh(mesh.nodes, {kind.meshio_name: mesh.cells[kind]}), file_format, binary=binary
    )
    again = read_gmsh(path)
    np.testing.assert_allclose(again.nodes, mesh.nodes, rtol=1e-15)
    np.testing.assert_array_equal(again.cells[kind], mesh.cells[kind])
    assert not again.node_sets
    assert not again.cell_sets


GMSH_ORDER = {
    CellType.TETRA10: [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    # Edges 01, 03, 04, 12, 14, 23, 24, 34, and 01, 02, 03, 12, 14, 25, 34, 35, 45.
    CellType.PYRAMID13: [0, 1, 2, 3, 4, 5, 8, 9, 6, 10, 7, 11, 12],
    CellType.WEDGE15: [0, 1, 2, 3, 4, 5, 6, 8, 12, 7, 13, 14, 9, 11, 10],
    CellType.HEXA20: [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14],
}


@pytest.mark.parametrize(
    ("kind", "number"),
    [(CellType.TETRA10, 11), (CellType.PYRAMID13, 19), (CellType.WEDGE15, 18), (CellType.HEXA20, 17)],
)
def test_middle_nodes_are_reordered(kind, number, tmp_path):
    """The node order of the Gmsh manual, section 'Node ordering'."""
    mesh = read_gmsh(one_cell(tmp_path, number, reference_nodes(kind)[GMSH_ORDER[kind]]))
    np.testing.assert_array_equal(mesh.nodes[mesh.cells[kind][0]], reference_nodes(kind))


def one_cell(folder, number, nodes):
    """A file of one cell, of the type of that number."""
    lines = [f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(nodes)]
    cell = f"1 {number} 2 1 1 " + " ".join(map(str, range(1, len(nodes) + 1)))
    parts = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes)), *lines, "$EndNodes"]
    path = folder / "one.msh"
    path.write_text("\n".join([*parts, "$Elements", "1", cell, "$EndElements", ""]))
    return path


@pytest.mark.parametrize(
    ("kind", "number", "inner"),
    [(CellType.PYRAMID13, 14, 1), (CellType.WEDGE15, 13, 3), (CellType.HEXA20, 12, 7)],
)
def test_nodes_inside_faces_and_cells_are_left_out(kind, number, inner, tmp_path):
    """Also of the group that the cell is in; the order of the others is that without them."""
    middle = np.full((inner, 3), 0.25)
    mesh = read_gmsh(one_cell(tmp_path, number, np.vstack([reference_nodes(kind)[GMSH_ORDER[kind]], middle])))
    assert mesh.n_nodes == kind.n_nodes
    np.testing.assert_array_equal(mesh.nodes[mesh.cells[kind][0]], reference_nodes(kind))
    (name,) = mesh.node_sets
    assert len(mesh.nodes_of(name)) == kind.n_nodes


SQUARE = np.array([[0, 0], [2, 0], [2, 1], [0, 1], [1, 0], [2, 0.5], [1, 1], [0, 0.5], [1, 0.5]])


@pytest.mark.parametrize(
    ("number", "places", "triangles", "area"),
    [
        (9, [[0, 0], [2, 0], [0, 2], [1, 0], [1, 1], [0, 1]], 4, 2.0),
        (16, SQUARE[:8], 6, 2.0),
        (10, SQUARE, 6, 2.0),
    ],
)
def test_surfaces_of_second_order_become_triangles(number, places, triangles, area, tmp_path):
    nodes = np.column_stack([places, np.zeros(len(places))])
    mesh = read_gmsh(one_cell(tmp_path, number, nodes))
    assert mesh.n_nodes == min(len(nodes), 8)
    cells = mesh.cells[CellType.TRIANGLE3]
    assert len(cells) == triangles
    a, b, c = np.moveaxis(mesh.nodes[cells], 1, 0)
    normals = np.cross(b - a, c - a)[:, 2] / 2
    assert (normals > 0).all()
    assert normals.sum() == pytest.approx(area)
    np.testing.assert_array_equal(mesh.cell_ids[CellType.TRIANGLE3], np.ones(triangles))


def test_quadrilaterals_become_triangles(changed):
    """Triangles 4 and 5 of the format 4 file as one quadrilateral, in the same physical groups."""
    path = changed(TEXT_4, "2 1 2 4\n4 1 5 4 \n5 4 5 6 \n", "2 1 3 1\n4 1 5 6 4 \n2 1 2 2\n")
    path.write_text(path.read_text().replace("$Elements\n4 7", "$Elements\n5 6"))
    mesh = read_gmsh(path)
    assert mesh.n_cells == 4
    for name in ("skin", "whole plate"):
        np.testing.assert_array_equal(mesh.cells_of(name)[CellType.TRIANGLE3], np.arange(4))


def test_a_quadrilateral_whose_sides_cross(changed):
    path = changed(TEXT_4, "2 1 2 4\n4 1 5 4 \n5 4 5 6 \n", "2 1 3 1\n4 1 6 5 4 \n2 1 2 2\n")
    path.write_text(path.read_text().replace("$Elements\n4 7", "$Elements\n5 6"))
    with pytest.raises(ImportFormatError, match="quadrilateral 4: its sides cross"):
        read_gmsh(path)


def test_only_one_group(changed):
    """The first two triangles keep surface 1's groups; the last two get surface 3 alone."""
    path = changed(TEXT_2, "10 2 2 1 1 6 2 3", "10 2 2 3 1 6 2 3")
    path.write_text(path.read_text().replace("11 2 2 2 1 6 2 3", "11 2 2 3 1 6 2 3"))
    mesh = read_gmsh(path, only="surface 3")
    np.testing.assert_allclose(mesh.nodes, [[2, 0, 0], [2, 1, 0], [1, 1, 0]], atol=1e-10)
    assert set(mesh.node_sets) == {"corner", "curve 7", "skin", "whole plate", "surface 3"}
    assert set(mesh.cell_sets) == {"surface 3"}


def test_only_a_surface_of_a_solid(tmp_path):
    mesh = block(1.0, 1.0, 1.0, 1, 1, 1, CellType.TETRA4)
    skin = np.array([[0, 1, 3], [0, 3, 2]])
    path = tmp_path / "solid.msh"
    cells = [("triangle", skin), ("tetra", mesh.cells[CellType.TETRA4])]
    tags = [np.full(2, 5), np.full(mesh.n_cells, 5)]
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    meshio.write(path, meshio.Mesh(mesh.nodes, cells, cell_data=data), "gmsh22", binary=False)
    assert read_gmsh(path).only_cell_type() is CellType.TETRA4
    surface = read_gmsh(path, only="surface 5")
    assert surface.n_nodes == 4
    np.testing.assert_array_equal(surface.nodes[surface.cells[CellType.TRIANGLE3]], mesh.nodes[skin])


def test_only_names_a_group():
    with pytest.raises(
        ImportFormatError, match=r"no cell set 'hub' to read; the file has 'skin', 'whole plate'"
    ):
        read_gmsh(TEXT_4, only="hub")


def test_unused_nodes(changed):
    path = changed(TEXT_2, "$Nodes\n6\n", "$Nodes\n7\n9 5 5 5\n")
    with pytest.raises(MeshError, match=r"format_2_text\.msh: 1 orphan node \(9\).*at \(5, 5, 5\)"):
        read_gmsh(path)
    mesh = read_gmsh(path, unused_nodes=UnusedNodes.DROP)
    np.testing.assert_array_equal(mesh.nodes, read_gmsh(TEXT_2).nodes)


# --- errors


def test_missing_file(tmp_path):
    with pytest.raises(ImportFormatError, match=r"absent\.msh: no such file"):
        read_gmsh(tmp_path / "absent.msh")


def test_not_a_gmsh_file(tmp_path):
    path = tmp_path / "notes.msh"
    path.write_text("nothing of the kind\n")
    with pytest.raises(ImportFormatError, match=r"notes\.msh: no \$MeshFormat section; is this a Gmsh mesh"):
        read_gmsh(path)


@pytest.mark.parametrize("path", FORMATS, ids=lambda path: path.stem)
@pytest.mark.parametrize("section", ["Nodes", "Elements"])
def test_cut_file(path, section, tmp_path):
    whole = path.read_bytes()
    start, end = whole.index(f"${section}".encode()), whole.index(f"$End{section}".encode())
    cut = tmp_path / "cut.msh"
    cut.write_bytes(whole[: (start + end) // 2])
    line = whole[:start].count(b"\n") + 1
    with pytest.raises(ImportFormatError, match=rf"cut\.msh, line {line}: \${section} has no \$End{section}"):
        read_gmsh(cut)
    cut.write_bytes(whole[:start])
    with pytest.raises(ImportFormatError, match=rf"cut\.msh: no \${section} section"):
        read_gmsh(cut)


@pytest.mark.parametrize("path", [TEXT_2, TEXT_4], ids=lambda path: path.stem)
def test_lines_missing_inside_a_section(path, changed):
    node = "3 2 1 0\n" if path is TEXT_2 else "2 1 0\n"
    with pytest.raises(
        ImportFormatError, match=r"not readable as a Gmsh mesh .*; save the whole mesh from Gmsh again"
    ):
        read_gmsh(changed(path, node, ""))


@pytest.mark.parametrize(
    ("path", "old", "new"),
    [(TEXT_2, "\n6 1.000000000004119", "\n8 1.000000000004119"), (TEXT_4, "1 3 0 1\n6\n", "1 3 0 1\n8\n")],
    ids=["format_2", "format_4"],
)
def test_cell_naming_a_missing_node(path, old, new, changed):
    with pytest.raises(
        ImportFormatError, match=r"triangle cell \d .* names a node that the file does not define"
    ):
        read_gmsh(changed(path, old, new))


def test_unknown_element_type(tmp_path):
    path = one_cell(tmp_path, 21, np.random.default_rng(0).random((10, 3)))
    with pytest.raises(
        ImportFormatError,
        match=r"cells of type 'triangle10' are not read; .* first or second order: line, triangle, ",
    ):
        read_gmsh(path)


def test_no_cells(changed):
    elements = TEXT_4.read_text().partition("$Elements\n")[2].partition("$EndElements")[0]
    with pytest.raises(ImportFormatError, match=r"format_4_text\.msh: no cells; mesh the geometry"):
        read_gmsh(changed(TEXT_4, elements, "0 0 0 0\n"))


def test_two_groups_of_one_name(changed):
    with pytest.raises(
        ImportFormatError, match=r"line 9: a second physical group is named 'root'; give each"
    ):
        read_gmsh(changed(TEXT_2, '2 2 "whole plate"', '2 2 "root"'))


def test_a_mesh_that_cannot_be_used_names_the_file(changed):
    with pytest.raises(MeshError, match=r"format_2_text\.msh: 1 degenerate TRIANGLE3 cell"):
        read_gmsh(changed(TEXT_2, "3 2 1 0\n", "3 1.5 0.5 0\n"))
