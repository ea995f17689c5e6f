"""Cell files: what formats of points and cells hold, before any meaning, and the mesh of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.errors import ImportFormatError
from supple.importers.file_mesh import FileMesh, UnusedNodes
from supple.importers.numbering import numbers_of
from supple.importers.quadrilateral import (
    CROSSED,
    crossed_quadrilaterals,
    split_quadratic_surfaces,
    split_quadrilaterals,
)
from supple.mesh import CellType, Mesh

__all__ = [
    "WITHOUT_INNER",
    "CellElements",
    "CellFile",
    "cell_elements",
    "cell_file_mesh",
    "without_inner_nodes",
]

IntArray = NDArray[np.int64]
FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_CELL_TYPES = {kind.meshio_name: kind for kind in CellType if kind.dimension > 1}
_SURFACES = {"quad": 4, "triangle6": 6, "quad8": 8}
_ENTITIES = ("point", "curve", "surface", "volume")  # Gmsh's words for dimensions 0 to 3
# Cells with nodes inside faces or themselves, as the cells without these.
WITHOUT_INNER = {
    "quad9": ("quad8", 8), "pyramid14": ("pyramid13", 13), "wedge18": ("wedge15", 15),
    "hexahedron27": ("hexahedron20", 20),
}  # fmt: skip


@dataclass(frozen=True)
class CellElements:
    """Elements of one type.

    type_name : as a `CellType` names its shape;  dimension : 0 to 3
    ids : (E,) element tags;  nodes : (E, k) node tags
    groups : {physical tag: (E,) which of them are in that group}
    dropped : (E, j) tags of the nodes inside faces and cells, which are not read
    """

    type_name: str
    dimension: int
    ids: IntArray
    nodes: IntArray
    groups: dict[int, NDArray[np.bool_]]
    dropped: IntArray


@dataclass(frozen=True)
class CellFile:
    """What a file holds: tags (N,) and positions (N, 3) of its nodes, and its elements in blocks."""

    tags: IntArray
    positions: FloatArray
    blocks: tuple[CellElements, ...]


@dataclass(frozen=True)
class _Block:
    """Cells of one type, and for each physical group which of them are in it."""

    type_name: str
    dimension: int
    cells: IntArray
    groups: dict[str, BoolArray]
    ids: IntArray


def cell_elements(
    name: str, dimension: int, ids: IntArray, nodes: IntArray, groups: dict[int, BoolArray]
) -> CellElements:
    """Elements of a type, without the nodes inside their faces, which are listed last."""
    name, n = WITHOUT_INNER.get(name, (name, nodes.shape[1]))
    return CellElements(name, dimension, ids, nodes[:, :n], groups, nodes[:, n:])


def without_inner_nodes(tags: IntArray, positions: FloatArray, blocks: tuple[CellElements, ...]) -> CellFile:
    """The file without the nodes that elements have dropped and none uses."""
    dropped, used = (
        np.concatenate([np.zeros(0, dtype=np.int64), *(getattr(block, part).ravel() for block in blocks)])
        for part in ("dropped", "nodes")
    )
    kept = ~np.isin(tags, np.setdiff1d(dropped, used))
    return CellFile(tags[kept], positions[kept], blocks)


def cell_file_mesh(
    path: Path,
    read: CellFile,
    names: Mapping[tuple[int, int], str],
    *,
    only: str | None,
    unused_nodes: UnusedNodes,
    node_sets: Mapping[str, IntArray] | None = None,
) -> Mesh:
    """The mesh of the cells of the highest dimension; groups are node sets, of that dimension cell sets too.

    Parameters
    ----------
    names : {(dimension, tag): name} of groups; others are called after their dimension and tag
    only : str or None            a group: its cells and nodes alone
    node_sets : {name: tags}      beside those of groups
    Raises
    ------
    ImportFormatError   unknown cell type, cells naming missing nodes
    MeshError           what the file describes is no usable mesh
    """
    blocks = _blocks(path, read, names)
    of_groups = {
        name: np.unique(np.concatenate([b.cells[b.groups[name]].ravel() for b in blocks if name in b.groups]))
        for name in dict.fromkeys(name for block in blocks for name in block.groups)
    }
    given = {} if node_sets is None else node_sets
    found = {name: numbers_of(read.tags, tags) for name, tags in given.items()}
    listed = {name: numbers[known] for name, (numbers, known) in found.items()}
    asked = [block for block in blocks if only in block.groups] or blocks
    dimension = max(block.dimension for block in asked)
    chosen = [block for block in blocks if block.dimension == dimension]
    cells, cell_sets, cell_ids = _cells_by_type(path, read.positions, chosen)
    return FileMesh(
        path, read.positions, cells, of_groups | listed, cell_sets, node_ids=read.tags, cell_ids=cell_ids
    ).to_mesh(only=only, unused_nodes=unused_nodes)


def _blocks(path: Path, read: CellFile, names: Mapping[tuple[int, int], str]) -> list[_Block]:
    blocks = []
    for elements in read.blocks:
        cells, known = numbers_of(read.tags, elements.nodes)
        lost = np.flatnonzero(~known.all(axis=1))
        if lost.size:
            raise ImportFormatError(
                f"{path}: {elements.type_name} cell {lost[0]} (of its block, from 0) names a node that the "
                "file does not define; save the mesh from Gmsh anew"
            )
        groups: dict[str, BoolArray] = {}
        for tag, inside in elements.groups.items():
            name = names.get((elements.dimension, tag), f"{_ENTITIES[elements.dimension]} {tag}")
            groups[name] = inside
        if len(cells):
            blocks.append(_Block(elements.type_name, elements.dimension, cells, groups, elements.ids))
    if not blocks:
        raise ImportFormatError(f"{path}: no cells; mesh the geometry before saving it")
    return blocks


def _cells_by_type(
    path: Path, points: NDArray[np.float64], blocks: list[_Block]
) -> tuple[dict[CellType, IntArray], dict[str, dict[CellType, IntArray]], dict[CellType, IntArray]]:
    by_kind: dict[CellType, list[_Block]] = {}
    for block in blocks:
        if block.type_name in _SURFACES:
            by_kind.setdefault(CellType.TRIANGLE3, []).append(_in_triangles(path, points, block))
        elif block.type_name in _CELL_TYPES:
            by_kind.setdefault(_CELL_TYPES[block.type_name], []).append(block)
        else:
            raise ImportFormatError(
                f"{path}: unknown element type '{block.type_name}'; supported are "
                f"{', '.join([*_CELL_TYPES, *_SURFACES])} (in Gmsh: Mesh.ElementOrder = 1 or 2)"
            )
    cells: dict[CellType, IntArray] = {}
    cell_sets: dict[str, dict[CellType, IntArray]] = {}
    cell_ids: dict[CellType, IntArray] = {}
    for kind, parts in by_kind.items():
        repeated = np.vstack([part.cells for part in parts])
        first, number = _first_of_each(repeated)
        cells[kind] = repeated[first]
        cell_ids[kind] = np.concatenate([part.ids for part in parts])[first]
        for name in dict.fromkeys(name for part in parts for name in part.groups):
            inside = np.concatenate(
                [part.groups.get(name, np.zeros(len(part.cells), bool)) for part in parts]
            )
            cell_sets.setdefault(name, {})[kind] = np.unique(number[inside])
    return cells, cell_sets, cell_ids


def _in_triangles(path: Path, points: NDArray[np.float64], block: _Block) -> _Block:
    """Triangles over all nodes of its surfaces, in the same groups."""
    if block.type_name == "quad":
        crossed = crossed_quadrilaterals(points, block.cells)
        if crossed.size:
            raise ImportFormatError(f"{path}: quadrilateral {crossed[0]} (of its block, from 0): {CROSSED}")
        triangles = split_quadrilaterals(points, block.cells)
    else:
        triangles = split_quadratic_surfaces(points, block.cells)
    n = len(triangles) // len(block.cells)
    groups = {name: np.repeat(inside, n) for name, inside in block.groups.items()}
    return _Block("triangle", 2, triangles, groups, np.repeat(block.ids, n))


def _first_of_each(cells: IntArray) -> tuple[IntArray, IntArray]:
    """Rows where each set of nodes first appears, in order; and for every row its place among these."""
    _, first, same = np.unique(np.sort(cells, axis=1), axis=0, return_index=True, return_inverse=True)
    in_order = np.argsort(first)
    place = np.empty_like(in_order)
    place[in_order] = np.arange(len(in_order))
    return first[in_order], place[same.ravel()]
