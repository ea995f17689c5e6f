"""Exodus II meshes (.exo, .e, .ex2, .g) in classic netCDF or HDF5 files.

Source: L. A. Schoof, V. R. Yarberry, EXODUS II: a finite element data model, SAND92-2137, 1994.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import scipy  # its parts are imported when first used
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.arrays import FloatArray, IntArray
from supple.copied_hdf5 import open_copied
from supple.errors import ImportFormatError
from supple.importers.cell_blocks import LAYERED, CellBlock, file_mesh
from supple.importers.file_mesh import FileMesh, UnusedNodes
from supple.importers.text_file import file_content, unreadable
from supple.mesh import CellType, Mesh

__all__ = ["EXODUS_SUFFIXES", "read_exodus"]

EXODUS_SUFFIXES = (".exo", ".e", ".ex2", ".g")
"""Suffixes of Exodus files."""

_Parts = Mapping[str, tuple[NDArray, str]]
_HDF5 = b"\x89HDF\r\n\x1a\n"
_NAMES = {
    "BAR": "line", "BEAM": "line", "TRUSS": "line", "EDGE": "line", "TRI": "triangle", "TRIANGLE": "triangle",
    "TRISHELL": "triangle", "QUAD": "quad", "SHELL": "quad", "TET": "tetra", "TETRA": "tetra",
    "PYR": "pyramid", "PYRAMID": "pyramid", "WED": "wedge", "WEDGE": "wedge", "HEX": "hexahedron",
}  # fmt: skip
_SIZES = {
    "line": {2: "line", 3: "line3"}, "triangle": {3: "triangle", 6: "triangle6"},
    "quad": {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"},
    "tetra": {4: "tetra", 10: "tetra10"}, "pyramid": {5: "pyramid", 13: "pyramid13", 14: "pyramid14"},
    "wedge": {6: "wedge", 15: "wedge15", 18: "wedge18"},
    "hexahedron": {8: "hexahedron", 20: "hexahedron20", 27: "hexahedron27"},
}  # fmt: skip
# Corners of each side in the order of Exodus; the sides of a shell are its two faces, then its edges. Other
# surfaces (QUAD, and TRI in two dimensions) have no faces among their sides.
_SIDES = {
    "hexahedron": ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3), (0, 3, 2, 1), (4, 5, 6, 7)),
    "tetra": ((0, 1, 3), (1, 2, 3), (0, 3, 2), (0, 2, 1)),
    "wedge": ((0, 1, 4, 3), (1, 2, 5, 4), (0, 3, 5, 2), (0, 2, 1), (3, 4, 5)),
    "pyramid": ((0, 1, 4), (1, 2, 4), (2, 3, 4), (0, 4, 3), (0, 3, 2, 1)),
    "triangle": ((0, 1, 2), (0, 1, 2), (0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1, 2, 3), (0, 1, 2, 3), (0, 1), (1, 2), (2, 3), (3, 0)),
}


@checked_arguments
def read_exodus(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of an Exodus file: its cells of the highest dimension, its blocks as cell sets.

    Node sets and side sets become node sets. Sets and blocks without names are called nodeset_ID, sideset_ID
    and block_ID. Parameters and errors are those of `read_mesh`.
    """
    path = Path(path)
    try:
        parts = _parts(path)
        return _file_mesh(path, parts).to_mesh(only=only, unused_nodes=unused_nodes)
    except (KeyError, IndexError, OSError, TypeError, ValueError, OverflowError, AttributeError) as error:
        raise unreadable(path, "Exodus", error) from error


def _parts(path: Path) -> _Parts:
    """Values and element type of each variable; the type is empty if the file gives none."""
    content = file_content(path)
    if content.startswith(_HDF5):
        with open_copied(path, ("/",)) as file:
            return {
                name: (each[()], _text(each.attrs.get("elem_type", b"")))
                for name, each in file.items()
                if hasattr(each, "shape")
            }
    if content[:3] != b"CDF":
        raise ImportFormatError(f"{path}: neither netCDF nor HDF5; is this an Exodus file?")
    # Reading from memory limits arrays to the size of the file, whatever a damaged header claims.
    with scipy.io.netcdf_file(io.BytesIO(content), "r", mmap=False) as file:
        return {
            name: (np.array(each.data), _text(getattr(each, "elem_type", b"")))
            for name, each in file.variables.items()
        }


def _text(value: object) -> str:
    return value.decode("latin-1").strip("\0 ") if isinstance(value, bytes) else str(value).strip("\0 ")


def _file_mesh(path: Path, parts: _Parts) -> FileMesh:
    nodes = _coordinates(parts)
    blocks, shapes = [], []
    flat = len(parts["coord"][0]) < 3 if "coord" in parts else "coordz" not in parts
    first = 0
    n_cells = sum(len(parts[name][0]) for name in _numbered(parts, "connect"))
    ids = _values(parts, "elem_num_map", np.arange(1, n_cells + 1))
    for name, label in _named(parts, "connect", "eb", "block"):
        cells, given = parts[name]
        cells = np.asarray(cells, dtype=np.int64) - 1
        word = "".join(letter for letter in given.upper() if letter.isalpha())
        shape = _NAMES.get(word, "")
        kind = _SIZES.get(shape, {}).get(cells.shape[1])
        own = ids[first : first + len(cells)]
        # A SHELL of three nodes is a triangle.
        side = "triangle" if kind and kind.startswith("triangle") else kind and shape
        skipped = 2 if word == "QUAD" or (flat and side == "triangle") else 0
        shapes.append((_SIDES.get(side or "", ())[skipped:], side, cells))
        first += len(cells)
        if word in ("SPHERE", "NODE"):
            continue
        if kind is None:
            raise ImportFormatError(
                f"{path}: block '{label}' has {given or 'nameless'} elements of {cells.shape[1]} nodes, "
                f"which are not read; supported are {', '.join(_NAMES)}"
            )
        if shape in LAYERED:
            order = [*LAYERED[shape], *range(len(LAYERED[shape]), cells.shape[1])][: cells.shape[1]]
            cells = cells[:, order]
            shapes[-1] = (*shapes[-1][:2], cells)
        blocks.append(CellBlock(kind, cells, own, {label: np.ones(len(cells), dtype=bool)}))
    sets = {}
    for name, label in _named(parts, "node_ns", "ns", "nodeset"):
        sets[label] = np.unique(np.asarray(parts[name][0], dtype=np.int64) - 1)
    for name, label in _named(parts, "elem_ss", "ss", "sideset"):
        sides = np.asarray(parts[name.replace("elem_", "side_")][0], dtype=np.int64) - 1
        sets[label] = _on_sides(shapes, np.asarray(parts[name][0], dtype=np.int64) - 1, sides)
    for label, members in sets.items():
        if members.size and not 0 <= members.min() <= members.max() < len(nodes):
            raise ImportFormatError(f"{path}: set '{label}' names a node that the file lacks; write it again")
    node_ids = _values(parts, "node_num_map", np.arange(1, len(nodes) + 1))
    return file_mesh(path, nodes, blocks, {k: v for k, v in sets.items() if v.size}, node_ids)


def _coordinates(parts: _Parts) -> FloatArray:
    if "coord" in parts:
        rows = np.asarray(parts["coord"][0], dtype=np.float64)
    else:
        rows = np.array(
            [parts[name][0] for name in ("coordx", "coordy", "coordz") if name in parts], dtype=float
        )
    flat = np.zeros((rows.shape[1], 3))
    flat[:, : len(rows)] = rows.T
    return flat


def _numbered(parts: _Parts, prefix: str) -> list[str]:
    """Variables PREFIX1, PREFIX2, .. in their order."""
    found = [name for name in parts if name.startswith(prefix) and name[len(prefix) :].isdigit()]
    return sorted(found, key=lambda name: int(name[len(prefix) :]))


def _values(parts: _Parts, name: str, else_: IntArray) -> IntArray:
    found = np.asarray(parts[name][0], dtype=np.int64) if name in parts else else_
    return found if len(np.unique(found)) == len(else_) else else_


def _named(parts: _Parts, prefix: str, kind: str, word: str) -> list[tuple[str, str]]:
    """Variables PREFIX1, PREFIX2, .. with the names of their blocks or sets, or their ids if without names.

    Empty blocks and sets have a number, id and name, but no variable. Repeated names get a number.
    """
    variables = _numbered(parts, prefix)
    numbers = [int(name[len(prefix) :]) for name in variables]
    n = max(numbers, default=0)
    ids = np.asarray(parts[f"{kind}_prop1"][0]).tolist() if f"{kind}_prop1" in parts else range(1, n + 1)
    given = [""] * n
    if f"{kind}_names" in parts:
        given = [b"".join(np.asarray(row).tolist()).decode("latin-1") for row in parts[f"{kind}_names"][0]]
    found = [
        name.split("\0")[0].strip() or f"{word}_{number}" for name, number in zip(given, ids, strict=False)
    ]
    labels = [name if found.count(name) == 1 else f"{name}_{i + 1}" for i, name in enumerate(found)]
    return [(name, labels[number - 1]) for name, number in zip(variables, numbers, strict=True)]


def _on_sides(
    shapes: list[tuple[tuple[tuple[int, ...], ...], str | None, IntArray]],
    elements: IntArray,
    sides: IntArray,
) -> IntArray:
    """Nodes of sides of elements, including middle nodes.

    shapes : for each block the corners of its sides, its shape and its cells
    """
    found, first = [np.empty(0, dtype=np.int64)], 0
    for corners_of_sides, shape, cells in shapes:
        own = (elements >= first) & (elements < first + len(cells))
        for number, corners in enumerate(corners_of_sides):
            chosen = cells[elements[own & (sides == number)] - first]
            places = [*corners]
            kind = next((k for k in CellType if k.meshio_name == shape), None)
            edges = kind.edges if kind is not None else tuple((i, (i + 1) % 4) for i in range(4))
            n = kind.n_corners if kind is not None else 4
            places += [n + i for i, edge in enumerate(edges) if set(edge) <= set(corners)]
            found.append(chosen[:, [i for i in places if i < cells.shape[1]]].ravel())
        first += len(cells)
    return np.unique(np.concatenate(found))
