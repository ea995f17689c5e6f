"""Gmsh meshes (.msh, formats 2 and 4, text or binary)."""

from __future__ import annotations

import codecs
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import IntArray
from supple.errors import ImportFormatError
from supple.importers.cell_blocks import CellBlock, file_mesh
from supple.importers.file_mesh import UnusedNodes
from supple.importers.gmsh_file import GmshElements, read_gmsh_file
from supple.importers.numbering import positions_of_ids
from supple.importers.text_file import file_content
from supple.mesh import Mesh

__all__ = ["read_gmsh"]


_ENTITIES = ("point", "curve", "surface", "volume")  # Gmsh's words for dimensions 0 to 3


@checked_arguments
def read_gmsh(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of a Gmsh file: its cells of the highest dimension, and its physical groups as sets.

    Every physical group becomes a node set; a group of the highest dimension becomes a cell set, too. A group
    without a name is named by its dimension and tag, as in 'surface 7'. Quadrilaterals and surfaces of
    second order become triangles over all nodes on their edges. Nodes inside faces and cells of second order
    (such as hexahedra with 27 nodes) are left out. Format 2 repeats a cell for each of its groups; such a
    cell is read once. With a group of a lower dimension as `only`, the cells of that dimension are read.
    The centres of arcs are unused nodes. Parameters and errors are those of `read_mesh`.
    """
    path = Path(path)
    text = _whole_text(path)
    names = _physical_names(path, text)
    tags, positions, elements = read_gmsh_file(path, text.encode("latin-1"))
    blocks = _blocks(path, tags, elements, names)
    node_sets = {
        name: np.unique(np.concatenate([b.cells[b.sets[name]].ravel() for _, b in blocks if name in b.sets]))
        for name in dict.fromkeys(name for _, block in blocks for name in block.sets)
    }
    selected = [each for each in blocks if only in each[1].sets] or blocks
    highest = max(dimension for dimension, _ in selected)
    by_type: dict[str, list[CellBlock]] = {}
    for dimension, block in blocks:
        if dimension == highest:
            by_type.setdefault(block.type_name, []).append(block)
    once = [_each_once(name, parts) for name, parts in by_type.items()]
    return file_mesh(path, positions, once, node_sets, tags).to_mesh(only=only, unused_nodes=unused_nodes)


def _whole_text(path: Path) -> str:
    """The bytes of the file as characters; ImportFormatError if it is missing or cut short."""
    text = file_content(path).removeprefix(codecs.BOM_UTF8).decode("latin-1")
    for section in ("MeshFormat", "Nodes", "Elements"):
        start = text.find(f"${section}")
        if start < 0:
            raise ImportFormatError(f"{path}: no ${section} section; is this a Gmsh mesh, and complete?")
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
        # Sets are identified by name, so two groups of one name would become one set.
        if name in names.values():
            raise ImportFormatError(
                f"{path}, line {_line(text, section.start(1) + found.start(3))}: a second physical group is "
                f"named '{name}'; give each group a different name"
            )
        names[int(found[1]), int(found[2])] = name
    return names


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


def _blocks(
    path: Path, tags: IntArray, read: Sequence[GmshElements], names: dict[tuple[int, int], str]
) -> list[tuple[int, CellBlock]]:
    """Dimension and cells of each block, with node numbers from 0 and the physical groups as sets."""
    blocks = []
    for elements in read:
        cells, known = positions_of_ids(tags, elements.nodes)
        lost = np.flatnonzero(~known.all(axis=1))
        if lost.size:
            raise ImportFormatError(
                f"{path}: {elements.type_name} cell {lost[0]} (of its block, from 0) names a node that the "
                "file does not define; save the mesh from Gmsh again"
            )
        groups = {
            names.get((elements.dimension, tag), f"{_ENTITIES[elements.dimension]} {tag}"): inside
            for tag, inside in elements.groups.items()
        }
        if len(cells):
            blocks.append((elements.dimension, CellBlock(elements.type_name, cells, elements.ids, groups)))
    if not blocks:
        raise ImportFormatError(f"{path}: no cells; mesh the geometry before saving it")
    return blocks


def _each_once(type_name: str, parts: Sequence[CellBlock]) -> CellBlock:
    """Cells of one type, each once; a cell belongs to the sets of all its repetitions."""
    cells = np.vstack([part.cells for part in parts])
    _, first, same = np.unique(np.sort(cells, axis=1), axis=0, return_index=True, return_inverse=True)
    in_order = np.argsort(first)
    place = np.argsort(in_order)[same.ravel()]
    sets = {}
    for name in dict.fromkeys(name for part in parts for name in part.sets):
        inside = np.concatenate([part.sets.get(name, np.zeros(len(part.cells), bool)) for part in parts])
        sets[name] = np.bincount(place[inside], minlength=len(first)) > 0
    ids = np.concatenate([part.ids for part in parts])
    return CellBlock(type_name, cells[first[in_order]], ids[first[in_order]], sets)
