"""Conversion of cell blocks of Gmsh, VTU, Exodus and Ansys files to the library's cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.file_mesh import FileMesh
from supple.importers.quadrilateral import (
    CROSSED,
    crossed_quadrilaterals,
    split_quadratic_surfaces,
    split_quadrilaterals,
)
from supple.mesh import CellType

_CELL_TYPES = {kind.meshio_name: kind for kind in CellType}
# Cell types with nodes inside faces or volume, and the types and numbers of nodes without these.
_FEWER = {"hexahedron27": ("hexahedron20", 20), "wedge18": ("wedge15", 15), "pyramid14": ("pyramid13", 13)}
_SURFACES = {"quad": 4, "triangle6": 6, "quad8": 8, "quad9": 9}


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

    Raises
    ------
    ImportFormatError   no cells; an unsupported type; missing nodes; crossed quadrilaterals
    """
    ours = [_cut(path, nodes, block) for block in blocks if len(block.cells)]
    if not ours:
        raise ImportFormatError(f"{path}: no cells; write the mesh with its cells")
    dimension = max(kind.dimension for kind, _ in ours)
    node_sets, cell_sets = dict(node_sets), {}
    cells: dict[CellType, list[IntArray]] = {}
    ids: dict[CellType, list[IntArray]] = {}
    for kind, block in ours:
        start = sum(len(part) for part in cells.get(kind, ()))
        if kind.dimension == dimension:
            cells.setdefault(kind, []).append(block.cells)
            ids.setdefault(kind, []).append(block.ids)
        for name, inside in block.sets.items():
            if not inside.any():
                continue
            held = np.unique(block.cells[inside])
            node_sets[name] = np.union1d(node_sets.get(name, held), held)
            if kind.dimension == dimension:
                members = cell_sets.setdefault(name, {}).setdefault(kind, [])
                members.append(start + np.flatnonzero(inside))
    return FileMesh(
        path,
        nodes,
        {kind: np.concatenate(parts) for kind, parts in cells.items()},
        node_sets,
        {
            name: {kind: np.concatenate(parts) for kind, parts in by_kind.items()}
            for name, by_kind in cell_sets.items()
        },
        node_ids=node_ids,
        cell_ids={kind: np.concatenate(parts) for kind, parts in ids.items()},
    )


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
        triangles = split_quadratic_surfaces(nodes, cells[:, : 8 if name == "quad9" else None])
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
