"""Part of a mesh: some of its cells as a separate mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from supple.arrays import IntArray
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh

__all__ = ["MeshPart", "mesh_part"]


@dataclass(frozen=True, eq=False)
class MeshPart:
    """Some cells of a whole mesh as a mesh, with their numbers in the whole mesh.

    mesh  : Mesh                            the part; its nodes and cells are in the order of the whole
    nodes : int array (N,)                  number, in the whole mesh, of each node of the part, ascending
    cells : {CellType: int array (E,)}      number, in the whole mesh, of each cell, within its type
    """

    mesh: Mesh
    nodes: IntArray
    cells: Mapping[CellType, IntArray]

    def numbers(self, nodes: IntArray) -> IntArray:
        """Convert node numbers of the whole mesh to those of the part, which must contain all the nodes."""
        return np.searchsorted(self.nodes, nodes)


def mesh_part(
    mesh: Mesh,
    cells: Mapping[CellType, IntArray],
    node_sets: Mapping[str, IntArray] | None = None,
    *,
    loose: IntArray | None = None,
) -> MeshPart:
    """The part of a mesh formed by some of its cells, with the links between its nodes.

    Cell sets are restricted to the part; empty ones are left out.

    Parameters
    ----------
    cells : {CellType: int array (E,)}          numbers of the cells, within their type
    node_sets : {name: int array}               nodes of the part, numbered as in the whole mesh
    loose : int array                           further nodes of the part, without cells

    Raises
    ------
    MeshError   cells that are not connected
    """
    kept = {kind: np.sort(numbers) for kind, numbers in cells.items() if len(numbers)}
    in_cells = [mesh.cells[kind][numbers].ravel() for kind, numbers in kept.items()]
    nodes = np.unique(np.concatenate([*in_cells, *([] if loose is None else [loose])]))
    links = mesh.links[np.isin(mesh.links, nodes).all(axis=1)]
    sets = {name: np.searchsorted(nodes, members) for name, members in (node_sets or {}).items()}
    part = Mesh(
        mesh.nodes[nodes],
        {kind: np.searchsorted(nodes, mesh.cells[kind][numbers]) for kind, numbers in kept.items()},
        sets,
        cell_sets_of(mesh.cell_sets, kept),
        mesh.node_ids[nodes],
        {kind: mesh.cell_ids[kind][numbers] for kind, numbers in kept.items()},
        np.searchsorted(nodes, links),
    )
    return MeshPart(part, nodes, kept)


def cell_sets_of(
    cell_sets: Mapping[str, Mapping[CellType, IntArray]], kept: Mapping[CellType, IntArray]
) -> dict[str, dict[CellType, IntArray]]:
    """The cell sets of a mesh, restricted to the kept cells and renumbered, without empty ones."""
    found = {}
    for name, members in cell_sets.items():
        own = {
            kind: np.flatnonzero(np.isin(numbers, members[kind]))
            for kind, numbers in kept.items()
            if kind in members
        }
        present = {kind: numbers for kind, numbers in own.items() if len(numbers)}
        if present:
            found[name] = present
    return found
