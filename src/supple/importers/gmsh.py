"""Gmsh meshes (.msh, formats 2 and 4, text or binary)."""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.errors import ImportFormatError
from supple.importers.file_mesh import FileMesh, UnusedNodes
from supple.importers.gmsh_file import GmshFile, read_gmsh_file
from supple.importers.numbering import numbers_of
from supple.importers.quadrilateral import (
    CROSSED,
    crossed_quadrilaterals,
    split_quadratic_surfaces,
    split_quadrilaterals,
)
from supple.importers.text_file import file_content
from supple.mesh import CellType, Mesh

__all__ = ["read_gmsh"]

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_CELL_TYPES = {kind.meshio_name: kind for kind in CellType if kind.dimension > 1}
_SURFACES = {"quad": 4, "triangle6": 6, "quad8": 8}
_ENTITIES = ("point", "curve", "surface", "volume")  # Gmsh's words for dimensions 0 to 3


@dataclass(frozen=True)
class _Block:
    """Cells of one type, and for each physical group which of them are in it."""

    type_name: str
    dimension: int
    cells: IntArray
    groups: dict[str, BoolArray]
    ids: IntArray


@checked_arguments
def read_gmsh(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of a Gmsh file: its cells of the highest dimension, and its physical groups as sets.

    Every physical group becomes a node set; those of the highest dimension are cell sets, too. A group
    without a name is called after its dimension and tag, as in 'surface 7'. Quadrilaterals and surfaces of
    second order become triangles over all their nodes; nodes inside faces and cells of second order (of
    hexahedra with 27 nodes, say) are left out. A cell that the file repeats, once for each of its groups
    (format 2), is read once.

    Parameters
    ----------
    path : str or Path
    only : str or None            a physical group: read its cells and nodes alone; None reads everything
    unused_nodes : UnusedNodes    REFUSE or DROP nodes that no cell uses, such as the centres of arcs
    Returns
    -------
    Mesh   nodes in the order of the file
    Raises
    ------
    ImportFormatError   missing, cut or unreadable file, unknown cell type, cells naming missing nodes
    MeshError           what the file describes is no usable mesh
    """
    path = Path(path)
    text = _whole_text(path)
    names = _physical_names(path, text)
    read = read_gmsh_file(path, text.encode("latin-1"))
    blocks = _blocks(path, read, names)
    node_sets = {
        name: np.unique(np.concatenate([b.cells[b.groups[name]].ravel() for b in blocks if name in b.groups]))
        for name in dict.fromkeys(name for block in blocks for name in block.groups)
    }
    asked = [block for block in blocks if only in block.groups] or blocks
    dimension = max(block.dimension for block in asked)
    chosen = [block for block in blocks if block.dimension == dimension]
    cells, cell_sets, cell_ids = _cells_by_type(path, read.positions, chosen)
    return FileMesh(
        path, read.positions, cells, node_sets, cell_sets, node_ids=read.tags, cell_ids=cell_ids
    ).to_mesh(only=only, unused_nodes=unused_nodes)


def _whole_text(path: Path) -> str:
    """The file, bytes taken as characters; ImportFormatError when it is missing or cut short."""
    text = file_content(path).removeprefix(codecs.BOM_UTF8).decode("latin-1")
    for section in ("MeshFormat", "Nodes", "Elements"):
        start = text.find(f"${section}")
        if start < 0:
            raise ImportFormatError(f"{path}: no ${section} section; is this a Gmsh mesh, and whole?")
        if f"$End{section}" not in text:
            raise ImportFormatError(
                f"{path}, line {_line(text, start)}: ${section} has no $End{section}; the file is cut short"
            )
    return text


def _physical_names(path: Path, text: str) -> dict[tuple[int, int], str]:
    """Names of the physical groups by dimension and tag."""
    section = re.search(r"\$PhysicalNames\s(.*?)\$EndPhysicalNames", text, flags=re.DOTALL)
    names: dict[tuple[int, int], str] = {}
    if section is None:
        return names
    for found in re.finditer(r'^\s*([0-3])\s+([0-9]{1,18})\s+"(.*)"', section[1], flags=re.MULTILINE):
        name = found[3].encode("latin-1").decode("utf-8", errors="replace")
        # A set has one name: of two groups the first would vanish.
        if name in names.values():
            raise ImportFormatError(
                f"{path}, line {_line(text, section.start(1) + found.start(3))}: a second physical group is "
                f"named '{name}'; give each group a name of its own"
            )
        names[int(found[1]), int(found[2])] = name
    return names


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


def _blocks(path: Path, read: GmshFile, names: dict[tuple[int, int], str]) -> list[_Block]:
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
