"""Conversion of cell blocks of Gmsh, VTU, Exodus and Ansys files to the library's cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.file_mesh import FileMesh, joined
from supple.importers.quadrilateral import (
    CROSSED,
    crossed_quadrilaterals,
    split_quadratic_surfaces,
    split_quadrilaterals,
)
from supple.mesh import CellType

_CELL_TYPES = {kind.meshio_name: kind for kind in CellType}
# Cell types with nodes inside faces or volume, and the types and numbers of nodes without these.
_FEWER = {
    "quad9": ("quad8", 8), "hexahedron27": ("hexahedron20", 20), "wedge18": ("wedge15", 15),
    "pyramid14": ("pyramid13", 13),
}  # fmt: skip
_SURFACES = ("quad", "triangle6", "quad8")


LAYERED = {
    "hexahedron": (*range(12), *range(16, 20), *range(12, 16)),
    "wedge": (*range(9), *range(12, 15), *range(9, 12)),
}
"""Position of each node of the library's order in formats with middle nodes of bottom, upright, then top."""


@dataclass(frozen=True, eq=False)
class CellBlock:
    """Cells (n, k) of one type, with meshio's name and order of nodes, and their ids.

    sets : {name: (n,) mask of the members}
    """

    type_name: str
    cells: IntArray
    ids: IntArray
    sets: dict[str, BoolArray] = field(default_factory=dict)


def file_mesh(
    path: Path,
    nodes: FloatArray,
    blocks: Sequence[CellBlock],
    node_sets: dict[str, IntArray],
    node_ids: IntArray | None = None,
) -> FileMesh:
    """File mesh of the cells of the highest dimension; quadrilaterals, quadratic surfaces become triangles.

    Sets of these cells become cell sets and node sets; sets of cells of a lower dimension become node sets.
    Nodes inside faces and cells are left out.

    Raises
    ------
    ImportFormatError   no cells; an unsupported type; missing nodes; crossed quadrilaterals
    """
    ours = [_cut(path, nodes, block) for block in blocks if len(block.cells)]
    if not ours:
        raise ImportFormatError(f"{path}: no cells; write the mesh with its cells")
    dimension = max(kind.dimension for kind, _ in ours)
    node_sets, cell_sets = dict(node_sets), {}
    meshed = [(kind, block) for kind, block in ours if kind.dimension == dimension]
    for name in dict.fromkeys(name for _, block in ours for name in block.sets):
        own = [block.cells[block.sets[name]].ravel() for _, block in ours if name in block.sets]
        held = np.unique(np.concatenate(own))
        if held.size:
            node_sets[name] = np.union1d(node_sets.get(name, held), held)
        inside = joined(
            (kind, block.sets.get(name, np.zeros(len(block.cells), dtype=bool))) for kind, block in meshed
        )
        members = {kind: np.flatnonzero(mask) for kind, mask in inside.items() if mask.any()}
        if members:
            cell_sets[name] = members
    inner = np.zeros(len(nodes), dtype=bool)
    for block in blocks:
        inner[block.cells[:, _FEWER.get(block.type_name, ("", block.cells.shape[1]))[1] :]] = True
    whole = FileMesh(
        path,
        nodes,
        joined((kind, block.cells) for kind, block in meshed),
        node_sets,
        cell_sets,
        node_ids=node_ids,
        cell_ids=joined((kind, block.ids) for kind, block in meshed),
    )
    return whole.without_unused(inner)


def _cut(path: Path, nodes: FloatArray, block: CellBlock) -> tuple[CellType, CellBlock]:
    name, cells = block.type_name, block.cells
    if cells.min() < 0 or cells.max() >= len(nodes):
        raise ImportFormatError(
            f"{path}: {name} cells name node {int(cells.max())} (from 0) of {len(nodes)}; write it again"
        )
    if name in _FEWER:
        name, kept = _FEWER[name]
        cells = cells[:, :kept]
    if name == "line3":
        return CellType.LINE2, _split(block, cells[:, [[0, 2], [2, 1]]].reshape(-1, 2), 2)
    if name in _SURFACES:
        if name == "quad":
            crossed = crossed_quadrilaterals(nodes, cells)
            if crossed.size:
                raise ImportFormatError(f"{path}: quadrilateral {block.ids[crossed[0]]}: {CROSSED}")
            return CellType.TRIANGLE3, _split(block, split_quadrilaterals(nodes, cells), 2)
        triangles = split_quadratic_surfaces(nodes, cells)
        return CellType.TRIANGLE3, _split(block, triangles, len(triangles) // len(cells))
    if name not in _CELL_TYPES:
        raise ImportFormatError(
            f"{path}: cells of type '{name}' are not read; write cells of first or second order: "
            f"{', '.join([*_CELL_TYPES, *_SURFACES, *_FEWER])}"
        )
    return _CELL_TYPES[name], CellBlock(name, cells, block.ids, block.sets)


def _split(block: CellBlock, cells: IntArray, each: int) -> CellBlock:
    sets = {name: np.repeat(inside, each) for name, inside in block.sets.items()}
    return CellBlock("", cells, np.repeat(block.ids, each), sets)
