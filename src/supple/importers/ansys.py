"""Ansys archives (.cdb, written by CDWRITE): nodes, elements and components as sets, by mapdl-archive."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import BoolArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.cell_blocks import CellBlock, file_mesh
from supple.importers.file_mesh import UnusedNodes
from supple.importers.numbering import positions_of_ids
from supple.importers.text_file import file_content, unreadable
from supple.mesh import Mesh

__all__ = ["read_ansys"]

# Numbers of element types, their cells, and the number of nodes that define the cell.
_SHAPES = (
    ((5, 45, 65, 70, 164, 185), "hexahedron", 8),
    ((90, 95, 186, 226, 231), "hexahedron20", 20),
    ((285,), "tetra", 4),
    ((87, 92, 98, 187, 227, 232), "tetra10", 10),
    ((28, 41, 43, 63, 131, 143, 157, 181), "quad", 4),
    ((91, 93, 99, 132, 281), "quad8", 8),
    ((3, 4, 8, 180, 188), "line", 2),
    ((189,), "line3", 3),
)
# Ignored types: springs, masses, contact, surface effect, MPC184 and MESH200; they are no cells.
_PASSED_OVER = (14, 21, 151, 152, 153, 154, 155, 156, 169, 170, 171, 172, 173, 174, 175, 176, 177, 184, 200)
_INFORMATION = 10
# Degenerate bricks: linear and quadratic cell, its nodes in the brick (corners, then middles), number of
# corners, pairs of repeated nodes.
_DEGENERATE = (
    ("tetra", "tetra10", (0, 1, 2, 4, 8, 9, 11, 16, 17, 18), 4, ((2, 3), (4, 5), (5, 6), (6, 7))),
    ("pyramid", "pyramid13", (0, 1, 2, 3, 4, 8, 9, 10, 11, 16, 17, 18, 19), 5, ((4, 5), (5, 6), (6, 7))),
    ("wedge", "wedge15", (0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 15, 16, 17, 18), 6, ((2, 3), (6, 7))),
)


@checked_arguments
def read_ansys(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of an Ansys archive (.cdb): its cells of the highest dimension.

    Components of nodes and elements become sets, and so do the elements of each material: material_ID. Bricks
    with repeated nodes become wedges, pyramids or tetrahedra. Orientation nodes of beams are unused nodes.
    Parameters and errors are those of `read_mesh`; also ImportFormatError without the library mapdl-archive
    (install `supple[ansys]`).
    """
    path = Path(path)
    try:
        from mapdl_archive import Archive
    except ImportError as error:
        raise ImportFormatError(
            f"{path}: Ansys archives are read by the library mapdl-archive; pip install 'supple[ansys]', "
            "or write the mesh in another format"
        ) from error
    content = file_content(path)
    for word in (b"NBLOCK", b"EBLOCK"):
        if word not in content.upper():
            raise ImportFormatError(f"{path}: no {word.decode()}; write it by CDWRITE,DB with blocked format")
    try:
        archive = Archive(path, parse_vtk=False)
        nodes, ids = np.array(archive.nodes, dtype=np.float64)[:, :3], np.array(archive.nnum, dtype=np.int64)
        elements = [np.array(each, dtype=np.int64) for each in archive.elem]
        routines = {int(each[0]): int(each[1]) for each in np.array(archive.ekey).reshape(-1, 2)}
        node_parts = {name: np.array(each, dtype=np.int64) for name, each in archive.node_components.items()}
        parts = {name: np.array(each, dtype=np.int64) for name, each in archive.element_components.items()}
    except Exception as error:  # the library raises any error on a damaged file
        raise unreadable(path, "an Ansys archive", error) from error
    blocks = _blocks(path, elements, routines, ids, parts)
    sets = {}
    for name, members in node_parts.items():
        numbers, known = positions_of_ids(ids, members)
        if known.any():
            sets[name] = np.unique(numbers[known])
    return file_mesh(path, nodes, blocks, sets, ids).to_mesh(only=only, unused_nodes=unused_nodes)


def _blocks(
    path: Path,
    elements: list[IntArray],
    routines: dict[int, int],
    node_ids: IntArray,
    parts: dict[str, IntArray],
) -> list[CellBlock]:
    by_shape: dict[str, list[tuple[IntArray, int, int]]] = {}
    for row in elements:
        routine, number = routines.get(int(row[1]), 0), int(row[8])
        if routine in _PASSED_OVER:
            continue
        name, nodes = _shape(path, routine, number, row[_INFORMATION:])
        by_shape.setdefault(name, []).append((nodes, number, int(row[0])))
    blocks = []
    for name, given in by_shape.items():
        cells, known = positions_of_ids(node_ids, np.array([nodes for nodes, _, _ in given]))
        if not known.all():
            lost = int(np.flatnonzero(~known.all(axis=1))[0])
            raise ImportFormatError(
                f"{path}: element {given[lost][1]} names a node that is not there; write it again"
            )
        ids, materials = (np.array([each[i] for each in given]) for i in (1, 2))
        sets: dict[str, BoolArray] = {f"material_{m}": materials == m for m in np.unique(materials).tolist()}
        sets |= {label: np.isin(ids, members) for label, members in parts.items()}
        blocks.append(CellBlock(name, cells, ids, sets))
    return blocks


def _shape(path: Path, routine: int, number: int, nodes: IntArray) -> tuple[str, IntArray]:
    """Cell type and node ids of an element, without the repeated nodes of a quadrilateral or brick."""
    name, n = next(((name, n) for types, name, n in _SHAPES if routine in types), ("", 0))
    if not name:
        raise ImportFormatError(
            f"{path}: element {number} is of type {routine}, which is not read; supported are solids 185 to "
            "187 and 285, shells 181 and 281, beams and links 180, 188, 189, and their forerunners"
        )
    nodes = nodes[:n]
    if len(nodes) < n or (nodes <= 0).any():
        raise ImportFormatError(
            f"{path}: element {number} lacks middle nodes; fill them in (EMID), or mesh with linear elements"
        )
    if name.startswith("hexahedron"):
        return _brick(name, nodes)
    if name.startswith("quad") and nodes[2] == nodes[3]:
        return ("triangle", nodes[:3]) if n == 4 else ("triangle6", nodes[[0, 1, 2, 4, 5, 7]])
    return name, nodes


def _brick(name: str, nodes: IntArray) -> tuple[str, IntArray]:
    """Cell type and node ids of a brick, or of a simpler cell if nodes of the brick are repeated."""
    for linear, quadratic, order, corners, twice in _DEGENERATE:
        if all(nodes[i] == nodes[j] for i, j in twice):
            if len(nodes) > 8:
                return quadratic, nodes[list(order)]
            return linear, nodes[list(order[:corners])]
    return name, nodes
