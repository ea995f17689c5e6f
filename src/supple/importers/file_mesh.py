"""File mesh: the contents of a mesh file before the checks of a Mesh, and the conversion to a Mesh."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum, auto
from pathlib import Path
from typing import TypeVar

import numpy as np

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.errors import CellError, ImportFormatError, MeshError
from supple.mesh import CellType, Mesh
from supple.mesh.mesh import no_ids
from supple.mesh.mesh_part import cell_sets_of

__all__ = ["UnusedNodes"]

Numbers = TypeVar("Numbers", IntArray, BoolArray)


class UnusedNodes(Enum):
    """Treatment of nodes that no cell uses (reference points, construction points)."""

    REFUSE = auto()
    """Raise MeshError."""
    DROP = auto()
    """Drop unused nodes, also from node sets; a node set without other nodes is dropped."""


def joined(parts: Iterable[tuple[CellType, Numbers]]) -> dict[CellType, Numbers]:
    """Arrays of cells by type, those of one type joined in their order."""
    found: dict[CellType, list[Numbers]] = {}
    for kind, array in parts:
        found.setdefault(kind, []).append(array)
    return {kind: np.concatenate(arrays) for kind, arrays in found.items()}


@dataclass(frozen=True)
class FileMesh:
    """Nodes, cells and sets of a file, numbered from 0 in its order.

    node_ids : (N,) ids in the file; None without ids
    cell_ids : {CellType: (E,)} element ids in the file; cells of one element share its id
    cell_origins : {CellType: (E, 2)} line and element id of each cell, for formats with lines
    place : function from such a line to its place in words
    """

    path: Path
    nodes: FloatArray
    cells: dict[CellType, IntArray]
    node_sets: dict[str, IntArray]
    cell_sets: dict[str, dict[CellType, IntArray]]
    cell_origins: Mapping[CellType, IntArray] = field(default_factory=dict)
    node_ids: IntArray | None = None
    cell_ids: Mapping[CellType, IntArray] = field(default_factory=dict)
    place: Callable[[int], str] = str

    def to_mesh(self, *, only: str | None, unused_nodes: UnusedNodes) -> Mesh:
        """The checked mesh of everything, or of the cell set `only` and its nodes."""
        chosen = self if only is None else self._only(only)
        if only is not None or unused_nodes is UnusedNodes.DROP:
            chosen = chosen.without_unused()
        try:
            return Mesh(
                chosen.nodes,
                chosen.cells,
                chosen.node_sets,
                chosen.cell_sets,
                no_ids() if chosen.node_ids is None else chosen.node_ids,
                chosen.cell_ids,
            )
        except MeshError as error:
            count = " (numbers count from 0, in the order of the file)" if chosen.node_ids is None else ""
            raise MeshError(f"{chosen._place_of(error)}: {error}{count}") from error

    def _place_of(self, error: MeshError) -> str:
        origins = self.cell_origins.get(CellType[error.kind]) if isinstance(error, CellError) else None
        if not isinstance(error, CellError) or origins is None:
            return str(self.path)
        line, element = origins[error.number]
        return f"{self.place(line)}: element {element}"

    def _only(self, name: str) -> FileMesh:
        if name not in self.cell_sets:
            known = ", ".join(f"'{known}'" for known in self.cell_sets) or "none"
            raise ImportFormatError(f"{self.path}: no cell set '{name}' to read; the file has {known}")
        kept = {kind: np.sort(members) for kind, members in self.cell_sets[name].items()}
        cells = {kind: self.cells[kind][members] for kind, members in kept.items()}
        return replace(
            self,
            cells=cells,
            cell_sets=cell_sets_of(self.cell_sets, kept),
            cell_origins={kind: of[kept[kind]] for kind, of in self.cell_origins.items() if kind in kept},
            cell_ids={kind: ids[kept[kind]] for kind, ids in self.cell_ids.items() if kind in kept},
        )

    def without_unused(self, among: BoolArray | None = None) -> FileMesh:
        """The file mesh without nodes that no cell uses: those of the mask `among` (N,), or all."""
        used = np.zeros(len(self.nodes), dtype=bool) if among is None else ~among
        for array in self.cells.values():
            used[array] = True
        number = np.cumsum(used) - 1
        node_sets = {name: number[members[used[members]]] for name, members in self.node_sets.items()}
        return replace(
            self,
            nodes=self.nodes[used],
            node_ids=None if self.node_ids is None else self.node_ids[used],
            cells={kind: number[array] for kind, array in self.cells.items()},
            node_sets={name: members for name, members in node_sets.items() if members.size},
        )
