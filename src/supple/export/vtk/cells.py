"""Cells in the numbering and node order of VTK."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from supple.arrays import IntArray
from supple.mesh import CellType, Mesh

VERTEX, LINE, TRIANGLE = 1, 3, 5

_TYPES = MappingProxyType(
    {
        CellType.LINE2: LINE,
        CellType.TRIANGLE3: TRIANGLE,
        CellType.TETRA4: 10,
        CellType.TETRA10: 24,
        CellType.PYRAMID5: 14,
        CellType.PYRAMID13: 27,
        CellType.WEDGE6: 13,
        CellType.WEDGE15: 26,
        CellType.HEXA8: 12,
        CellType.HEXA20: 25,
    }
)


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of several types, one after another.

    types : uint8 (E,)          VTK's numbers of the cell types
    offsets : int (E + 1,)      index of each cell's first node, and the total number of entries
    nodes : int (offsets[-1],)  numbers of points
    """

    types: NDArray[np.uint8]
    offsets: IntArray
    nodes: IntArray

    @classmethod
    def of(cls, *blocks: tuple[int, IntArray]) -> Cells:
        """Cells from blocks (VTK's number of the cell type, node numbers (E, k))."""
        counts = [np.full(len(nodes), nodes.shape[1]) for _, nodes in blocks]
        return cls(
            types=np.concatenate([np.full(len(nodes), kind, np.uint8) for kind, nodes in blocks]),
            offsets=np.concatenate([[0], np.cumsum(np.concatenate(counts))]),
            nodes=np.concatenate([nodes.ravel() for _, nodes in blocks]),
        )

    def of_some(self, chosen: NDArray[np.bool_]) -> Cells:
        """The cells selected by a mask (E,)."""
        counts = np.diff(self.offsets)
        return Cells(
            self.types[chosen],
            np.concatenate([[0], np.cumsum(counts[chosen])]),
            self.nodes[np.repeat(chosen, counts)],
        )


def joined(all_cells: Sequence[Cells], n_points: Sequence[int]) -> Cells:
    """The cells of several grids in one, with points and cells concatenated in the order of the grids."""
    first_point = np.cumsum([0, *n_points[:-1]])
    first_node = np.cumsum([0, *(len(cells.nodes) for cells in all_cells)])
    ends = [start + cells.offsets[1:] for start, cells in zip(first_node, all_cells, strict=False)]
    return Cells(
        np.concatenate([cells.types for cells in all_cells]),
        np.concatenate([[0], *ends]),
        np.concatenate([start + cells.nodes for start, cells in zip(first_point, all_cells, strict=True)]),
    )


def vtk_cells(mesh: Mesh) -> Cells:
    """All cells of a mesh, type by type; the node order is that of VTK."""
    return Cells.of(*((_TYPES[kind], nodes) for kind, nodes in mesh.cells.items()))
