"""Parametric shapes against geometry and topology: volume, area, closedness, Euler characteristic."""

import math

import numpy as np
import pytest

from supple.errors import MeshError
from supple.mesh import CellType, block, box_beam, cylinder, cylinder_shell, plate, strip
from supple.mesh.reference_cell import shape_gradients

SOLIDS = [kind for kind in CellType if kind.n_corners in (4, 8)]
LINEAR_SOLIDS = [CellType.TETRA4, CellType.HEXA8]
FACES = {
    3: [[0, 1, 2]],
    4: [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]],
    8: [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
}


def volume(mesh):
    """Sum of det dx/dxi over a quadrature that is exact here: degree 3 on tetrahedra, 5 on hexahedra."""
    kind = mesh.only_cell_type()
    if kind.n_corners == 4:
        points = np.vstack([np.full(3, 1 / 4), np.full(3, 1 / 6), np.full((3, 3), 1 / 6) + np.eye(3) / 3])
        weights = np.array([-4 / 5, 9 / 20, 9 / 20, 9 / 20, 9 / 20]) / 6
    else:
        x, w = np.polynomial.legendre.leggauss(3)
        points = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3)
        weights = np.einsum("i,j,k->ijk", w, w, w).ravel()
    J = np.einsum("eai,paj->epij", mesh.nodes[mesh.cells[kind]], shape_gradients(kind, points))
    return np.sum(np.linalg.det(J) @ weights)


def area_vectors(mesh):
    a, b, c = np.moveaxis(mesh.nodes[mesh.cells[CellType.TRIANGLE3]], 1, 0)
    return np.cross(b - a, c - a) / 2


def area(mesh):
    return np.linalg.norm(area_vectors(mesh), axis=1).sum()


def outward(mesh):
    """Area vectors along the radius in the y-z plane."""
    centres = mesh.nodes[mesh.cells[CellType.TRIANGLE3]].mean(axis=1) * [0, 1, 1]
    return np.einsum("ei,ei->e", centres, area_vectors(mesh))


def euler_characteristic(mesh):
    """Vertices - edges + faces - solids of linear cells: 1 for a disc or a ball, 0 for a tube."""
    kind = mesh.only_cell_type()
    cells = mesh.cells[kind]

    def count(parts):
        parts = np.array(parts)
        return len(np.unique(np.sort(cells[:, parts].reshape(-1, parts.shape[1]), axis=1), axis=0))

    solids = len(cells) if kind.dimension == 3 else 0
    return mesh.n_nodes - count(kind.edges) + count(FACES[kind.n_nodes]) - solids


def is_mirrored(mesh, axis):
    """Whether reflecting the mesh along an axis, about its middle, gives the same cells."""
    flipped = mesh.nodes.copy()
    flipped[:, axis] = flipped[:, axis].min() + flipped[:, axis].max() - flipped[:, axis]
    images = np.linalg.norm(flipped[:, None] - mesh.nodes, axis=2).argmin(axis=1)
    cells = mesh.cells[mesh.only_cell_type()]
    as_sets = lambda array: {frozenset(row) for row in array.tolist()}  # noqa: E731
    return as_sets(images[cells]) == as_sets(cells)


# --- strip and plate


def test_strip_covers_its_rectangle():
    mesh = strip(10.0, 0.5, 8, 2)
    assert area(mesh) == pytest.approx(5.0, rel=1e-14)
    assert area_vectors(mesh)[:, 2].min() > 0
    assert euler_characteristic(mesh) == 1
    np.testing.assert_array_equal(np.ptp(mesh.nodes, axis=0), [10.0, 0.5, 0.0])


def test_strip_sets():
    mesh = strip(10.0, 0.5, 8, 4)
    np.testing.assert_array_equal(mesh.nodes[mesh.nodes_of("tip_centre")], [[10.0, 0.0, 0.0]])
    np.testing.assert_array_equal(mesh.nodes[mesh.nodes_of("root_centre")], [[0.0, 0.0, 0.0]])
    np.testing.assert_allclose(mesh.nodes[mesh.nodes_of("axis"), 0], np.linspace(0, 10, 9))
    np.testing.assert_array_equal(np.flatnonzero(mesh.nodes[:, 0] == 0), mesh.nodes_of("root"))
    np.testing.assert_array_equal(np.flatnonzero(mesh.nodes[:, 0] == 10), mesh.nodes_of("tip"))


@pytest.mark.parametrize("n_width", [2, 4])
def test_strip_is_symmetric_about_its_axis(n_width):
    assert is_mirrored(strip(3.0, 1.0, 5, n_width), axis=1)


def test_strip_needs_nodes_on_its_axis():
    with pytest.raises(MeshError, match="n_width = 3 is odd"):
        strip(1.0, 1.0, 4, 3)


def test_plate_is_symmetric_both_ways():
    mesh = plate(2.0, 1.0, 4, 6)
    assert is_mirrored(mesh, axis=0)
    assert is_mirrored(mesh, axis=1)
    np.testing.assert_array_equal(mesh.nodes[mesh.nodes_of("centre")], [[1.0, 0.5, 0.0]])


def test_plate_boundary_is_the_union_of_its_edges():
    mesh = plate(2.0, 1.0, 3, 2)
    edges = [mesh.nodes_of(name) for name in ("x_min", "x_max", "y_min", "y_max")]
    np.testing.assert_array_equal(np.unique(np.concatenate(edges)), np.sort(mesh.nodes_of("boundary")))
    assert mesh.nodes_of("boundary").size == 2 * (3 + 2)
    assert "centre" not in mesh.node_sets
    assert area(mesh) == pytest.approx(2.0, rel=1e-14)
    assert euler_characteristic(mesh) == 1


# --- block


@pytest.mark.parametrize("kind", SOLIDS)
def test_block_volume_and_sides(kind):
    mesh = block(3.0, 2.0, 1.0, 3, 2, 2, kind)
    assert volume(mesh) == pytest.approx(6.0, rel=1e-13)
    sides = {"root": (0, 0.0), "tip": (0, 3.0), "y_min": (1, -1.0), "y_max": (1, 1.0), "z_min": (2, -0.5),
             "z_max": (2, 0.5)}  # fmt: skip
    for name, (axis, value) in sides.items():
        on_side = np.flatnonzero(np.isclose(mesh.nodes[:, axis], value, atol=1e-12))
        np.testing.assert_array_equal(np.sort(mesh.nodes_of(name)), on_side)


@pytest.mark.parametrize("kind", LINEAR_SOLIDS)
def test_block_is_a_ball_without_gaps(kind):
    """A face that neighbours cut differently would count twice and break the Euler characteristic."""
    assert euler_characteristic(block(1.0, 1.0, 1.0, 3, 2, 4, kind)) == 1


def test_block_has_six_tetrahedra_a_hexahedron():
    assert block(1.0, 1.0, 1.0, 3, 2, 1, CellType.TETRA10).n_cells == 6 * 3 * 2


def test_block_has_no_surface_cells():
    with pytest.raises(MeshError, match="TRIANGLE3 is no cell of this shape; choose TETRA4"):
        block(1.0, 1.0, 1.0, 1, 1, 1, CellType.TRIANGLE3)


# --- cylinder


@pytest.mark.parametrize("kind", LINEAR_SOLIDS)
def test_cylinder_is_the_prism_over_a_regular_polygon(kind):
    """4 n_core sides: V = L (n/2) R^2 sin(2 pi / n)."""
    mesh = cylinder(2.0, 5.0, 3, 2, 4, kind)
    assert volume(mesh) == pytest.approx(5.0 * 6 * 4.0 * math.sin(math.pi / 6), rel=1e-13)
    assert euler_characteristic(mesh) == 1


@pytest.mark.parametrize("kind", [CellType.TETRA10, CellType.HEXA20])
def test_quadratic_cylinder_converges_at_fourth_order(kind):
    """A parabola through three points of a circle misses its area by O(h^4)."""
    errors = [math.pi - volume(cylinder(1.0, 1.0, n, n, 1, kind)) for n in (2, 4)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize("kind", SOLIDS)
def test_cylinder_sets(kind):
    mesh = cylinder(2.0, 5.0, 2, 1, 3, kind)
    radius = np.linalg.norm(mesh.nodes[:, 1:], axis=1)
    np.testing.assert_array_equal(np.sort(mesh.nodes_of("surface")), np.flatnonzero(np.isclose(radius, 2.0)))
    np.testing.assert_array_equal(np.sort(mesh.nodes_of("root")), np.flatnonzero(mesh.nodes[:, 0] == 0))
    np.testing.assert_array_equal(np.sort(mesh.nodes_of("tip")), np.flatnonzero(mesh.nodes[:, 0] == 5))


# --- cylinder shell


def test_closed_cylinder_shell_is_a_tube_facing_outward():
    """n flat strips of width 2 R sin(pi / n)."""
    mesh = cylinder_shell(2.0, 3.0, 4, 12)
    assert area(mesh) == pytest.approx(12 * 3.0 * 4.0 * math.sin(math.pi / 12), rel=1e-13)
    assert outward(mesh).min() > 0
    assert euler_characteristic(mesh) == 0
    assert set(mesh.node_sets) == {"x_min", "x_max"}


def test_roof_has_its_edges():
    """The Scordelis-Lo roof: 80 degrees about the vertical."""
    half = math.radians(40)
    mesh = cylinder_shell(25.0, 50.0, 4, 6, start_angle=-half, end_angle=half)
    for name, side in (("start", -1), ("end", 1)):
        edge = mesh.nodes[mesh.nodes_of(name)]
        np.testing.assert_allclose(edge[:, 1], side * 25.0 * math.sin(half))
        np.testing.assert_allclose(edge[:, 2], 25.0 * math.cos(half))
        np.testing.assert_allclose(edge[:, 0], np.linspace(0, 50, 5))
    assert outward(mesh).min() > 0
    assert euler_characteristic(mesh) == 1
    assert is_mirrored(mesh, axis=1)


@pytest.mark.parametrize("end", [-0.1, 0.0, 6.5, math.nan])
def test_sector_must_run_forward_and_at_most_once_around(end):
    with pytest.raises(MeshError, match=rf"the sector runs from 0.0 to {end} rad"):
        cylinder_shell(1.0, 1.0, 1, 4, end_angle=end)


def test_a_tube_has_at_least_three_sides():
    with pytest.raises(MeshError, match="n_around = 2; give a whole number of cells, at least 3"):
        cylinder_shell(1.0, 1.0, 1, 2)


# --- box beam


def test_box_beam_is_a_rectangular_tube_facing_outward():
    mesh = box_beam(10.0, 2.0, 1.0, 6, 4, 2)
    assert area(mesh) == pytest.approx(2 * (2.0 + 1.0) * 10.0, rel=1e-13)
    assert outward(mesh).min() > 0
    assert euler_characteristic(mesh) == 0
    assert is_mirrored(mesh, axis=1)
    assert is_mirrored(mesh, axis=2)
    np.testing.assert_array_equal(np.flatnonzero(mesh.nodes[:, 0] == 10), mesh.nodes_of("tip"))


def test_box_beam_walls_face_their_names():
    mesh = box_beam(10.0, 2.0, 1.0, 6, 3, 2)
    normals = {"z_min": [0, 0, -1], "y_max": [0, 1, 0], "z_max": [0, 0, 1], "y_min": [0, -1, 0]}
    walls = {name: mesh.cells_of(name)[CellType.TRIANGLE3] for name in normals}
    for name, normal in normals.items():
        vectors = area_vectors(mesh)[walls[name]]
        np.testing.assert_allclose(vectors / np.linalg.norm(vectors, axis=1, keepdims=True),
                                   np.broadcast_to(normal, vectors.shape), atol=1e-14)  # fmt: skip
    np.testing.assert_array_equal(np.sort(np.concatenate(list(walls.values()))), np.arange(mesh.n_cells))


# --- arguments


@pytest.mark.parametrize("size", [0.0, -1.0, math.nan, math.inf])
@pytest.mark.parametrize(
    "shape",
    [
        lambda size: strip(size, 1.0, 1, 2),
        lambda size: plate(1.0, size, 1, 2),
        lambda size: block(1.0, 1.0, size, 1, 1, 1, CellType.HEXA8),
        lambda size: cylinder(size, 1.0, 1, 1, 1, CellType.HEXA8),
        lambda size: cylinder_shell(1.0, size, 1, 4),
        lambda size: box_beam(1.0, size, 1.0, 1, 1, 1),
    ],
)
def test_sizes_are_positive(shape, size):
    with pytest.raises(MeshError, match=rf"= {size}; give a finite size above zero"):
        shape(size)


@pytest.mark.parametrize("count", [0, -2, 1.5])
@pytest.mark.parametrize(
    "shape",
    [
        lambda count: strip(1.0, 1.0, count, 2),
        lambda count: plate(1.0, 1.0, 1, count),
        lambda count: block(1.0, 1.0, 1.0, 1, 1, count, CellType.HEXA8),
        lambda count: cylinder(1.0, 1.0, 1, count, 1, CellType.HEXA8),
        lambda count: cylinder_shell(1.0, 1.0, count, 4),
        lambda count: box_beam(1.0, 1.0, 1.0, 1, count, 1),
    ],
)
def test_counts_are_whole_and_positive(shape, count):
    with pytest.raises(MeshError, match=rf"= {count}; give a whole number of cells, at least 1"):
        shape(count)
