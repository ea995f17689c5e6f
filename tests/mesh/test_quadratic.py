"""Quadratic cells from linear ones share their edges' middle nodes."""

import numpy as np
import pytest

from supple.errors import MeshError
from supple.mesh import CellType, Mesh, block, strip, to_quadratic
from supple.mesh.reference_cell import reference_nodes

PAIRS = [(CellType.TETRA4, CellType.TETRA10), (CellType.HEXA8, CellType.HEXA20)]


@pytest.mark.parametrize(("linear", "quadratic"), PAIRS)
def test_one_cell_becomes_the_quadratic_reference_cell(linear, quadratic):
    mesh = to_quadratic(Mesh(reference_nodes(linear), {linear: np.arange(linear.n_nodes)[None]}))
    cell = mesh.nodes[mesh.cells[quadratic][0]]
    np.testing.assert_array_equal(cell, reference_nodes(quadratic))


@pytest.mark.parametrize(("linear", "quadratic"), PAIRS)
def test_one_new_node_for_each_edge(linear, quadratic):
    coarse = block(1.0, 1.0, 1.0, 2, 2, 2, linear)
    fine = to_quadratic(coarse)
    edges = np.unique(np.sort(coarse.cells[linear][:, np.array(linear.edges)].reshape(-1, 2), axis=1), axis=0)
    assert fine.n_nodes == coarse.n_nodes + len(edges)
    assert len(np.unique(fine.nodes.round(12), axis=0)) == fine.n_nodes
    assert list(fine.cells) == [quadratic]


def test_ids_stay_and_quadratic_cells_stay():
    linear = block(2.0, 1.0, 1.0, 2, 1, 1, CellType.HEXA8)
    ids, own = 10 + np.arange(linear.n_nodes), {CellType.HEXA8: np.array([7, 9])}
    mesh = to_quadratic(Mesh(linear.nodes, linear.cells, node_ids=ids, cell_ids=own))
    np.testing.assert_array_equal(mesh.node_ids, 10 + np.arange(mesh.n_nodes))
    np.testing.assert_array_equal(mesh.cell_ids[CellType.HEXA20], [7, 9])
    assert to_quadratic(mesh) is mesh


def test_sets_and_links_follow():
    sets = {"half": {CellType.HEXA8: [0]}}
    linear = block(2.0, 1.0, 1.0, 2, 1, 1, CellType.HEXA8)
    mesh = to_quadratic(Mesh(linear.nodes, linear.cells, linear.node_sets, sets, links=[[0, 5]]))
    np.testing.assert_array_equal(mesh.links, [[0, 5]])
    root = mesh.nodes_of("root")
    np.testing.assert_array_equal(np.sort(root), np.flatnonzero(mesh.nodes[:, 0] == 0))
    np.testing.assert_array_equal(root[:4], linear.nodes_of("root"))
    np.testing.assert_array_equal(mesh.cells_of("half")[CellType.HEXA20], [0])


def test_no_quadratic_triangles():
    with pytest.raises(MeshError, match="TRIANGLE3 cells have no quadratic form here"):
        to_quadratic(strip(1.0, 1.0, 1, 2))
