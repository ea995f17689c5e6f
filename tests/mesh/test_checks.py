"""Each mistake in a mesh has its own message, which names the place and the remedy."""

import numpy as np
import pytest

from supple.errors import MeshError
from supple.mesh import CellType, Mesh, block
from supple.mesh.reference_cell import reference_nodes

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TWO_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
SOLIDS = [kind for kind in CellType if kind.dimension == 3]


def square(nodes=SQUARE, triangles=TWO_TRIANGLES, node_sets=None, cell_sets=None):
    return Mesh(nodes, {CellType.TRIANGLE3: triangles}, node_sets or {}, cell_sets or {})


def one_cell(kind, nodes):
    return Mesh(nodes, {kind: np.arange(kind.n_nodes)[None]})


def test_a_sound_mesh_passes():
    mesh = square(node_sets={"edge": [0, 1]}, cell_sets={"half": {CellType.TRIANGLE3: [1]}})
    assert mesh.n_nodes == 4
    assert mesh.n_cells == 2


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_nodes_not_finite(bad):
    nodes = SQUARE.copy()
    nodes[2, 1] = bad
    with pytest.raises(MeshError, match=rf"1 node \(2\) not finite; node 2 is at \(1, {bad}, 0\)"):
        square(nodes)


@pytest.mark.parametrize("nodes", [SQUARE[:, :2], SQUARE[0], np.empty((0, 3))])
def test_nodes_of_wrong_shape(nodes):
    with pytest.raises(MeshError, match=r"nodes have shape .* expected \(N, 3\)"):
        square(nodes)


def test_no_cells():
    with pytest.raises(MeshError, match="no cells"):
        Mesh(SQUARE, {})


def test_cells_of_wrong_shape():
    with pytest.raises(MeshError, match=r"cells TRIANGLE3 have shape \(1, 4\); expected \(E, 3\)"):
        square(triangles=[[0, 1, 2, 3]])


def test_empty_cell_array():
    with pytest.raises(MeshError, match="cells TRIANGLE3 are empty"):
        square(triangles=np.empty((0, 3), dtype=int))


def test_cells_that_are_not_integers():
    with pytest.raises(MeshError, match="float64 values; node and cell numbers are integers"):
        square(triangles=TWO_TRIANGLES.astype(float))


@pytest.mark.parametrize("wrong", [-1, 4])
def test_node_number_out_of_range(wrong):
    with pytest.raises(MeshError, match=rf"with nodes outside 0 \.\. 3; cell 1 has nodes \[0, 2, {wrong}\]"):
        square(triangles=[[0, 1, 2], [0, 2, wrong]])


def test_repeated_node_in_a_cell():
    with pytest.raises(MeshError, match=r"repeated node; cell 1 has nodes \[0, 2, 0\]"):
        square(triangles=[[0, 1, 2], [0, 2, 0]])


def test_orphan_node():
    with pytest.raises(MeshError, match=r"1 orphan node \(3\).*node 3 is at \(0, 1, 0\)"):
        square(triangles=TWO_TRIANGLES[:1])


def test_empty_node_set():
    with pytest.raises(MeshError, match="node set 'tip' is empty"):
        square(node_sets={"tip": []})


@pytest.mark.parametrize("members", [{}, {CellType.TRIANGLE3: []}])
def test_empty_cell_set(members):
    with pytest.raises(MeshError, match="cell set 'skin' is empty"):
        square(cell_sets={"skin": members})


def test_set_of_wrong_shape():
    with pytest.raises(MeshError, match=r"node set 'tip' has shape \(1, 2\)"):
        square(node_sets={"tip": [[0, 1]]})


def test_set_members_out_of_range():
    with pytest.raises(MeshError, match="node set 'tip' contains 7, but the mesh has 4 nodes"):
        square(node_sets={"tip": [0, 7]})
    with pytest.raises(MeshError, match="cell set 'skin' contains 2, but the mesh has 2 TRIANGLE3 cells"):
        square(cell_sets={"skin": {CellType.TRIANGLE3: [2]}})
    with pytest.raises(MeshError, match="cell set 'skin' contains 0, but the mesh has 0 TETRA4 cells"):
        square(cell_sets={"skin": {CellType.TETRA4: [0]}})


def test_set_member_named_twice():
    with pytest.raises(MeshError, match="node set 'tip' has 1 more than once"):
        square(node_sets={"tip": [1, 0, 1]})


@pytest.mark.parametrize("height", [0.0, 1e-7])
def test_degenerate_triangle(height):
    nodes = np.array([[0, 0, 0], [1, 0, 0], [0.5, height, 0]])
    with pytest.raises(
        MeshError, match=r"1 degenerate TRIANGLE3 cell \(0\).*nodes \[0, 1, 2\] at \(0, 0, 0\)"
    ):
        one_cell(CellType.TRIANGLE3, nodes)


def test_a_slender_triangle_is_not_degenerate():
    one_cell(CellType.TRIANGLE3, np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-3, 0]]))


def test_triangles_may_turn_either_way():
    """A T-junction of webs and skin has no consistent orientation."""
    square(triangles=[[0, 1, 2], [0, 3, 2]])


@pytest.mark.parametrize("kind", SOLIDS)
def test_inverted_solid(kind):
    mirrored = reference_nodes(kind) * [1, 1, -1]
    with pytest.raises(MeshError, match=rf"1 inverted {kind.name} cell \(0\): the Jacobian is negative"):
        one_cell(kind, mirrored)


@pytest.mark.parametrize("kind", SOLIDS)
def test_degenerate_solid(kind):
    with pytest.raises(MeshError, match=rf"1 degenerate {kind.name} cell \(0\), with \(almost\) no volume"):
        one_cell(kind, reference_nodes(kind) * [1, 1, 0])


@pytest.mark.parametrize("kind", SOLIDS)
def test_a_slender_solid_is_not_degenerate(kind):
    one_cell(kind, reference_nodes(kind) * [1, 1e-3, 1e-3])


def test_a_quadratic_cell_is_inverted_by_a_misplaced_middle_node():
    """On an edge of length 1, dx/dxi = 1 + (4 m - 2) (L0 - L1), where L0 - L1 = 1/sqrt(5) at a strain point.

    Where the middle is below 1/4 the map folds at the node, which has no strain of its own.
    """
    limit = 0.5 - np.sqrt(5) / 4
    nodes = reference_nodes(CellType.TETRA10).copy()
    nodes[4, 0] = limit + 0.01
    one_cell(CellType.TETRA10, nodes)
    nodes[4, 0] = limit - 0.01
    with pytest.raises(MeshError, match="inverted TETRA10"):
        one_cell(CellType.TETRA10, nodes)


def test_disconnected_parts():
    nodes = np.vstack([SQUARE, SQUARE[:3] + np.array([5, 0, 0])])
    with pytest.raises(MeshError, match=r"2 disconnected parts, of 4, 3 nodes; node 4 at \(5, 0, 0\)"):
        square(nodes, [[0, 1, 2], [0, 2, 3], [4, 5, 6]])


def test_parts_joined_by_another_cell_type_are_connected():
    tetra = np.vstack([SQUARE[:3], [[0, 0, 1]], SQUARE[3:]])
    mesh = Mesh(tetra, {CellType.TETRA4: [[0, 1, 2, 3]], CellType.TRIANGLE3: [[0, 2, 4]]})
    assert mesh.n_cells == 2


def test_only_the_first_few_of_many_are_listed():
    mesh = block(1.0, 1.0, 1.0, 2, 2, 2, CellType.HEXA8)
    with pytest.raises(MeshError, match=r"8 inverted HEXA8 cells \(0, 1, 2, 3, 4, \.\.\.\)"):
        Mesh(mesh.nodes * [1, 1, -1], mesh.cells)
