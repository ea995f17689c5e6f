"""Mesh: nodes, cells by type, and named sets of nodes and of cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from supple.arguments import check_instance, check_numbers
from supple.arrays import FloatArray, IntArray
from supple.errors import MeshError
from supple.mesh.cell_type import CellType
from supple.mesh.checks import check_ids, check_mesh
from supple.summary import Summarized, Summary, place_text

__all__ = ["Mesh"]


def no_links() -> IntArray:
    """Default links: none."""
    return np.zeros((0, 2), dtype=np.int64)


def no_ids() -> IntArray:
    """Default ids: none; the labels of the nodes are then their numbers."""
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(Summarized):
    """Nodes, cells by type, and named sets of nodes and of cells.

    A mesh is connected; it has no unused nodes, no inverted cells and no flat cells.
    All arrays are copied and read-only.

    Parameters
    ----------
    nodes : float array (N, 3)          positions, m
    cells : {CellType: int array (E, k)}   node numbers of each cell, 0-based, ordered as in `CellType`
    node_sets : {name: int array}       node numbers; their order is kept, such as root to tip along an edge
    cell_sets : {name: {CellType: int array}}   cell numbers, counted within each type
    node_ids : int array (N,)           different labels of the nodes, such as the ids in a file; default: the
            node numbers
    cell_ids : {CellType: int array (E,)}   labels of the cells; default: the cell numbers. Several cells may
            have one label, such as the two triangles made of a quadrilateral
    links : int array (L, 2)            pairs of nodes connected by springs, masses or ties; these nodes need
            no cell

    Raises
    ------
    MeshError   NaN, arrays of wrong shapes, numbers out of range, an empty set, a node in no cell, a node
                twice in a cell, an inverted or flat cell, parts that are not connected
    """

    nodes: FloatArray
    cells: Mapping[CellType, IntArray]
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    cell_sets: Mapping[str, Mapping[CellType, IntArray]] = field(default_factory=dict)
    node_ids: IntArray = field(default_factory=no_ids)
    cell_ids: Mapping[CellType, IntArray] = field(default_factory=dict)
    links: IntArray = field(default_factory=no_links)

    def __post_init__(self) -> None:
        check_numbers("Mesh, nodes", self.nodes)
        for name in ("cells", "node_sets", "cell_sets"):
            check_instance(f"Mesh, {name}", getattr(self, name), Mapping, "a dictionary of arrays")
        for kind in self.cells:
            check_instance("Mesh, cells", kind, CellType, "a CellType as key, such as CellType.TETRA4")
        for members in self.cell_sets.values():
            check_instance("Mesh, cell_sets", members, Mapping, "a dictionary of arrays by CellType")
        nodes = np.array(self.nodes, dtype=np.float64)
        nodes.setflags(write=False)
        cells = {kind: _numbers(array, f"cells {kind.name}") for kind, array in self.cells.items()}
        node_sets = {name: _numbers(array, f"node set '{name}'") for name, array in self.node_sets.items()}
        cell_sets = {
            name: MappingProxyType(
                {kind: _numbers(array, f"cell set '{name}'") for kind, array in members.items()}
            )
            for name, members in self.cell_sets.items()
        }
        node_ids = _numbers(self.node_ids if len(self.node_ids) else np.arange(len(nodes)), "node ids")
        cell_ids = {
            kind: _numbers(self.cell_ids.get(kind, np.arange(len(array))), f"ids of cells {kind.name}")
            for kind, array in cells.items()
        }
        check_ids(nodes, cells, node_ids, cell_ids)
        links = _numbers(self.links, "links")
        check_mesh(nodes, cells, node_sets, cell_sets, node_ids, cell_ids, links)
        object.__setattr__(self, "links", links)
        object.__setattr__(self, "node_ids", node_ids)
        object.__setattr__(self, "cell_ids", MappingProxyType(cell_ids))
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "cells", MappingProxyType(cells))
        object.__setattr__(self, "node_sets", MappingProxyType(node_sets))
        object.__setattr__(self, "cell_sets", MappingProxyType(cell_sets))

    def __reduce__(self):
        # Mapping proxies do not pickle; rebuilding also keeps the arrays read-only.
        cell_sets = {name: dict(members) for name, members in self.cell_sets.items()}
        return Mesh, (
            *(self.nodes, dict(self.cells), dict(self.node_sets), cell_sets),
            *(self.node_ids, dict(self.cell_ids), self.links),
        )

    def summary(self) -> Summary:
        """Nodes, cells of each kind, extent and sets."""
        cells = ", ".join(f"{len(array)} {kind.name}" for kind, array in self.cells.items())
        rows = [("nodes", str(self.n_nodes))]
        rows += [(kind.name, f"{len(array)} cells") for kind, array in self.cells.items()]
        extent = zip("xyz", self.nodes.min(axis=0), self.nodes.max(axis=0), strict=True)
        rows += [(axis, f"{low:g} to {high:g}") for axis, low, high in extent]
        size = float(abs(self.nodes).max())
        for name, nodes in self.node_sets.items():
            centroid = place_text(self.nodes[nodes].mean(axis=0), size)
            rows.append((f"node set {name}", f"{len(nodes)} nodes, centroid {centroid}"))
        for name, members in self.cell_sets.items():
            rows.append((f"cell set {name}", f"{sum(map(len, members.values()))} cells"))
        return Summary(f"Mesh of {self.n_nodes} nodes, {cells or 'no cells'}", rows)

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.nodes)

    @property
    def n_cells(self) -> int:
        """Number of cells of all types."""
        return sum(len(array) for array in self.cells.values())

    def nodes_of(self, name: str) -> IntArray:
        """Node numbers of a node set; the MeshError for an unknown name lists all names."""
        if name not in self.node_sets:
            raise MeshError(f"no node set '{name}' in this mesh; it has {_listed(self.node_sets)}")
        return self.node_sets[name]

    def numbers_of(self, ids: ArrayLike) -> IntArray:
        """Node numbers of node ids; MeshError for an id that no node has."""
        wanted = _numbers(ids, "node ids")
        order = np.argsort(self.node_ids, kind="stable")
        place = np.minimum(np.searchsorted(self.node_ids[order], wanted), self.n_nodes - 1)
        found = order[place]
        lost = wanted[self.node_ids[found] != wanted]
        if lost.size:
            raise MeshError(
                f"no node of this mesh has the id {lost[0]}; its ids are {self.node_ids.min()} to "
                f"{self.node_ids.max()}" + ("" if self.has_own_ids else ", numbered from 0")
            )
        return found

    @property
    def has_own_ids(self) -> bool:
        """Whether the nodes have labels other than their numbers."""
        return not np.array_equal(self.node_ids, np.arange(self.n_nodes))

    def cells_of(self, name: str) -> Mapping[CellType, IntArray]:
        """Cell numbers, by type, of a cell set; the MeshError for an unknown name lists all names."""
        if name not in self.cell_sets:
            raise MeshError(f"no cell set '{name}' in this mesh; it has {_listed(self.cell_sets)}")
        return self.cell_sets[name]

    def only_cell_type(self) -> CellType:
        """The type of all cells; MeshError unless the mesh has exactly one type."""
        if len(self.cells) != 1:
            counts = ", ".join(f"{len(array)} {kind.name}" for kind, array in self.cells.items())
            raise MeshError(f"the mesh mixes cell types ({counts}); keep one, for instance by its cell set")
        return next(iter(self.cells))


def _numbers(array: ArrayLike, what: str) -> IntArray:
    given = np.asarray(array)
    if given.size and not np.issubdtype(given.dtype, np.integer):
        raise MeshError(f"{what} holds {given.dtype} values; node and cell numbers are integers")
    numbers = np.array(given, dtype=np.int64)
    numbers.setflags(write=False)
    return numbers


def _listed(sets: Mapping[str, object]) -> str:
    return ", ".join(f"'{name}'" for name in sets) or "none"
