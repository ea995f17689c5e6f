"""Quadratic cells from linear ones: a node in the middle of each edge."""

from __future__ import annotations

import numpy as np

from supple.errors import MeshError
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import IntArray, Mesh

__all__ = ["to_quadratic"]

_QUADRATIC = {
    CellType.TETRA4: CellType.TETRA10,
    CellType.PYRAMID5: CellType.PYRAMID13,
    CellType.WEDGE6: CellType.WEDGE15,
    CellType.HEXA8: CellType.HEXA20,
}


def to_quadratic(mesh: Mesh) -> Mesh:
    """The mesh with the quadratic type of each solid cell, such as TETRA10 for TETRA4; edges stay straight.

    New nodes follow the old, with ids above the largest; a node set contains a new node when it contains both
    ends of the edge. A mesh of quadratic cells is returned as it is.

    Raises
    ------
    MeshError   cells that have no quadratic form, or cells of both orders
    """
    if mesh.cells and set(mesh.cells) <= set(_QUADRATIC.values()):
        return mesh
    for kind in mesh.cells:
        if kind not in _QUADRATIC:
            raise MeshError(
                f"{kind.name} cells have no quadratic form here; only "
                f"{', '.join(each.name for each in _QUADRATIC)} do"
            )
    cell_edges = {kind: np.sort(array[:, np.array(kind.edges)], axis=2) for kind, array in mesh.cells.items()}
    all_edges = np.vstack([edges.reshape(-1, 2) for edges in cell_edges.values()])
    edges, edge_of = np.unique(all_edges, axis=0, return_inverse=True)
    middle = mesh.n_nodes + edge_of.ravel()

    cells, start = {}, 0
    for kind, array in mesh.cells.items():
        count = len(array) * len(kind.edges)
        cells[_QUADRATIC[kind]] = np.hstack([array, middle[start : start + count].reshape(len(array), -1)])
        start += count
    nodes = np.vstack([mesh.nodes, mesh.nodes[edges].mean(axis=1)])
    node_sets = {
        name: _with_middles(members, edges, mesh.n_nodes) for name, members in mesh.node_sets.items()
    }
    cell_sets = {
        name: {_QUADRATIC[kind]: members for kind, members in by_kind.items()}
        for name, by_kind in mesh.cell_sets.items()
    }
    node_ids = np.concatenate([mesh.node_ids, mesh.node_ids.max() + 1 + np.arange(len(edges))])
    cell_ids = {_QUADRATIC[kind]: ids for kind, ids in mesh.cell_ids.items()}
    return Mesh(nodes, cells, node_sets, cell_sets, node_ids, cell_ids, mesh.links)


def _with_middles(members: IntArray, edges: IntArray, n_nodes: int) -> IntArray:
    inside = np.zeros(n_nodes, dtype=bool)
    inside[members] = True
    return np.concatenate([members, n_nodes + np.flatnonzero(inside[edges].all(axis=1))])
