"""The skin of a mesh: closed around solids, with the right area, and lines only where elements meet."""

import numpy as np
import pytest
from fixtures.solid_blocks import LINEAR, QUADRATIC, solid_block

from supple.errors import ModelError
from supple.mesh import CellType, Mesh, block, box_beam, strip
from supple.mesh.feature_edges import feature_edges
from supple.mesh.outer_faces import outer_triangles
from supple.mesh.skin import Skin, skin_of


def area_vectors(nodes, triangles):
    a, b, c = np.moveaxis(nodes[triangles], 1, 0)
    return 0.5 * np.cross(b - a, c - a)


@pytest.mark.parametrize("cell_type", LINEAR + QUADRATIC)
def test_skin_of_a_solid_is_its_closed_outward_surface(cell_type):
    mesh = solid_block(2.0, 1.0, 0.5, 3, 2, 2, cell_type)
    triangles = skin_of(mesh).triangles
    areas = area_vectors(mesh.nodes, triangles)
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(2 * (2.0 * 1.0 + 2.0 * 0.5 + 1.0 * 0.5))
    # Gauss: the integral of x . n over an outward skin is three times the volume.
    centres = mesh.nodes[triangles].mean(axis=1)
    assert np.einsum("ti,ti->", centres, areas) == pytest.approx(3 * 2.0 * 1.0 * 0.5)


def test_skin_of_a_shell_is_the_shell():
    mesh = strip(2.0, 1.0, 4, 2)
    np.testing.assert_array_equal(skin_of(mesh).triangles, mesh.cells[CellType.TRIANGLE3])
    assert skin_of(mesh).mesh_lines.all()


@pytest.mark.parametrize(("cell_type", "per_face"), [(CellType.HEXA8, 4), (CellType.HEXA20, 8)])
def test_only_element_edges_are_lined(cell_type, per_face):
    # A face of a hexahedron shows its rim, of four sides or eight half sides, and none of the cuts across it.
    faces = skin_of(block(1.0, 1.0, 1.0, 2, 1, 1, cell_type))
    assert faces.mesh_lines.sum() == 10 * per_face
    mesh = block(1.0, 1.0, 1.0, 2, 1, 1, cell_type)
    start, end = faces.triangles[:, [1, 2, 0]], faces.triangles[:, [2, 0, 1]]
    along_axes = (np.abs(mesh.nodes[end] - mesh.nodes[start]) > 1e-9).sum(axis=2) == 1
    assert along_axes[faces.mesh_lines].all()


def test_outline_of_a_box_is_its_twelve_edges_without_the_cuts():
    mesh = block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8)
    edges = feature_edges(mesh.nodes, skin_of(mesh).triangles)
    assert len(edges) == 12
    lengths = np.linalg.norm(mesh.nodes[edges[:, 1]] - mesh.nodes[edges[:, 0]], axis=1)
    np.testing.assert_allclose(lengths, 1.0)


def test_outline_of_an_open_tube_has_its_rims():
    mesh = box_beam(4.0, 1.0, 1.0, 4, 2, 2)
    edges = feature_edges(mesh.nodes, skin_of(mesh).triangles)
    along = np.abs(mesh.nodes[edges[:, 1]] - mesh.nodes[edges[:, 0]])[:, 0] > 1e-9
    assert along.sum() == 4 * 4
    assert (~along).sum() == 2 * 8


def test_skin_arrays_are_checked():
    with pytest.raises(ModelError, match=r"triangles of shape \(0, 3\)"):
        Skin.of_triangles(np.empty((0, 3), dtype=int))
    with pytest.raises(ModelError, match=r"mesh lines of shape \(2, 3\) for triangles of shape \(1, 3\)"):
        Skin(np.array([[0, 1, 2]]), np.ones((2, 3), dtype=bool))


def test_faces_between_cells_of_two_types_lie_inside():
    """A pyramid on a hexahedron: eleven outer triangles' worth of five squares and four sides."""
    cube = block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8)
    top = cube.cells[CellType.HEXA8][0][list(CellType.HEXA8.faces[1])]
    nodes = np.vstack([cube.nodes, 1.8 * cube.nodes[top].mean(axis=0) - 0.8 * cube.nodes.mean(axis=0)])
    mesh = Mesh(nodes, {CellType.HEXA8: cube.cells[CellType.HEXA8], CellType.PYRAMID5: [[*top, 8]]})
    assert len(skin_of(mesh).triangles) == 5 * 2 + 4
    assert len(outer_triangles(mesh, np.arange(9))) == 5 * 2 + 4
