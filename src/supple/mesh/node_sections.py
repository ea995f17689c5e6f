"""Sections of nodes, where a mesh can be cut without passing through a cell.

A tie of parts along a surface that zigzags through a row of cells makes this whole row rigid. A section of
nodes is flat, and every cell is on one side of it. There are two families:

planes   normal to an axis, through nodes, that no cell crosses
layers   nodes at an equal number of steps, from cell to cell, from one end of the mesh, if these nodes are
   in a plane; a mesh swept along a curve has such layers
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh

# Largest distance between nodes of one plane, relative to the extent along the axis.
_SAME_PLANE = 1e-6
# Largest deviation of a section from a plane, relative to the extent of its cells along the normal.
_FLAT = 0.1


@dataclass(frozen=True, eq=False)
class NodeSection:
    """A section between the cells of a mesh.

    position : mean position of its nodes along the axis
    below : computes, for each cell type, whether the cells (E,) are on the lower side
    is_plane : whether the section is a plane normal to the axis; the nodes of a layer may not be in a plane
    """

    position: float
    below: Callable[[], Mapping[CellType, BoolArray]]
    is_plane: bool

    def contains(self, other: NodeSection) -> bool:
        """Whether the lower side of this section contains that of another, and at least one more cell."""
        mine, others = self.below(), other.below()
        pairs = [(mine[kind], others[kind]) for kind in mine]
        return all((own | ~lower).all() for own, lower in pairs) and any(
            (own & ~lower).any() for own, lower in pairs
        )


def sections_along(mesh: Mesh, direction: FloatArray) -> list[NodeSection]:
    """Planes normal to a direction, then layers from either end; not every layer is flat (`flat_section`)."""
    along = mesh.nodes @ direction
    return [
        *_planes(mesh, along),
        *_layers(mesh, along, from_low=True),
        *_layers(mesh, along, from_low=False),
    ]


def flat_section(mesh: Mesh, section: NodeSection) -> bool:
    """Whether the nodes on a section are in a plane, or in one plane for each of its pieces.

    The nodes may deviate from the plane by a tenth of the mean extent of their cells along its normal.
    """
    if section.is_plane:
        return True
    low_side = section.below()
    sides = [
        {kind: np.flatnonzero(below if low else ~below) for kind, below in low_side.items()}
        for low in (True, False)
    ]
    low, high = (
        np.concatenate([mesh.cells[kind][own].ravel() for kind, own in side.items()]) for side in sides
    )
    pieces = list(shared_pieces(mesh, sides, np.intersect1d(low, high)))
    return bool(pieces) and all(_is_flat(mesh, sides, nodes) for nodes in pieces)


def shared_pieces(
    mesh: Mesh, sides: Sequence[Mapping[CellType, IntArray]], shared: IntArray
) -> Iterator[IntArray]:
    """The common nodes of two sides of a mesh, divided into connected pieces."""
    if not len(shared):
        return
    rows, columns = [], []
    for side in sides:
        for kind, numbers in side.items():
            corners = mesh.cells[kind][numbers]
            on_cut = np.isin(corners, shared)
            touching = on_cut.sum(axis=1) > 1
            corners, on_cut = corners[touching], on_cut[touching]
            first = np.where(on_cut, corners, -1).max(axis=1, initial=-1)[:, None]
            rows.append(np.broadcast_to(first, corners.shape)[on_cut])
            columns.append(corners[on_cut])
    start, end = (np.searchsorted(shared, np.concatenate(ends)) for ends in (rows, columns))
    graph = coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=(len(shared),) * 2)
    n_pieces, piece = connected_components(graph, directed=False)
    for i in range(n_pieces):
        yield shared[piece == i]


def _is_flat(mesh: Mesh, sides: Sequence[Mapping[CellType, IntArray]], nodes: IntArray) -> bool:
    """Whether the nodes of one piece are near a plane, relative to the extent of the cells normal to it."""
    touching = [
        [
            cells[np.isin(cells, nodes).any(axis=1)]
            for cells in (mesh.cells[kind][own] for kind, own in side.items())
        ]
        for side in sides
    ]
    low, high = (mesh.nodes[np.unique(np.concatenate([c.ravel() for c in own]))] for own in touching)
    towards = high.mean(axis=0) - low.mean(axis=0)
    towards /= np.linalg.norm(towards)
    points = mesh.nodes[nodes] - mesh.nodes[nodes].mean(axis=0)
    heights = points @ towards
    beside = points - heights[:, None] * towards
    slope = np.linalg.lstsq(beside, heights, rcond=1e-9)[0]
    normal = (towards - slope) / np.hypot(1.0, np.linalg.norm(slope))
    extents = [np.ptp(mesh.nodes[cells] @ normal, axis=1) for own in touching for cells in own]
    return bool(np.ptp(points @ normal) <= _FLAT * np.concatenate(extents).mean())


def _planes(mesh: Mesh, along: FloatArray) -> Iterator[NodeSection]:
    near = _SAME_PLANE * np.ptp(along)
    extents = [(along[cells].min(axis=1), along[cells].max(axis=1)) for cells in mesh.cells.values()]
    low, high = (np.concatenate(ends) for ends in zip(*extents, strict=True))
    thick = high - low > 2 * near  # thin cells lie in a plane normal to the axis and cross no plane
    low, high = np.sort(low[thick]), np.sort(high[thick])
    levels = np.unique(along)
    levels = levels[np.concatenate([[True], np.diff(levels) > near])]
    levels = levels[(levels > along.min() + near) & (levels < along.max() - near)]
    crossing = np.searchsorted(low, levels - near) - np.searchsorted(high, levels + near, side="right")

    def below(level: float) -> Mapping[CellType, BoolArray]:
        return {kind: along[cells].mean(axis=1) < level - near for kind, cells in mesh.cells.items()}

    for level in levels[crossing == 0].tolist():
        yield NodeSection(level, partial(below, level), is_plane=True)


def _layers(mesh: Mesh, along: FloatArray, *, from_low: bool) -> Iterator[NodeSection]:
    """Layers by the number of steps from one end; a step leads from a cell to any cell with a common node."""
    height = along if from_low else -along
    ends = np.flatnonzero(height <= height.min() + _SAME_PLANE * np.ptp(height))
    n, counts = mesh.n_nodes, [len(cells) for cells in mesh.cells.values()]
    first = n + np.concatenate([[0], np.cumsum(counts)])
    pairs = [
        (np.repeat(begin + np.arange(len(cells)), cells.shape[1]), cells.ravel())
        for begin, cells in zip(first, mesh.cells.values(), strict=False)
    ]
    rows, columns = (np.concatenate(each) for each in zip(*pairs, strict=True))
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(int(first[-1]),) * 2).tocsr()
    steps = dijkstra(graph, directed=False, indices=ends, unweighted=True, min_only=True)
    steps = np.where(np.isfinite(steps), steps, 2.0 * first[-1]).astype(int)
    node_steps = steps[:n] // 2
    reached = node_steps[node_steps < first[-1]].max()

    def below(number: int) -> Mapping[CellType, BoolArray]:
        return {
            kind: (steps[begin : begin + count] < 2 * number) == from_low
            for kind, begin, count in zip(mesh.cells, first, counts, strict=False)
        }

    for number in range(1, int(reached)):
        position = float(along[node_steps == number].mean())
        yield NodeSection(position, partial(below, number), is_plane=False)
