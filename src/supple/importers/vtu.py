"""VTU meshes (VTK XML, UnstructuredGrid): text, base64 or raw data, plain or compressed by zlib.

Source: VTK file formats, XML formats, https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
"""

from __future__ import annotations

import base64
import binascii
import re
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.arrays import FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.cell_blocks import CellBlock, file_mesh
from supple.importers.file_mesh import UnusedNodes
from supple.importers.text_file import file_content
from supple.mesh import CellType, Mesh
from supple.mesh.reference_cell import mirrored_order

__all__ = ["read_vtu"]

# Numbers of VTK's cell types with meshio's names and their number of nodes. Vertices are no cells.
_TYPES = {
    3: ("line", 2), 5: ("triangle", 3), 9: ("quad", 4), 10: ("tetra", 4), 12: ("hexahedron", 8),
    13: ("wedge", 6), 14: ("pyramid", 5), 21: ("line3", 3), 22: ("triangle6", 6), 23: ("quad8", 8),
    24: ("tetra10", 10), 25: ("hexahedron20", 20), 26: ("wedge15", 15), 27: ("pyramid13", 13),
    28: ("quad9", 9), 29: ("hexahedron27", 27),
}  # fmt: skip
_VERTEX = 1
# Array of cell data whose first bit marks copies of the cells of another piece.
_GHOST = "vtkGhostType"
_KINDS = {
    "Float32": "f4", "Float64": "f8", "Int8": "i1", "Int16": "i2", "Int32": "i4", "Int64": "i8",
    "UInt8": "u1", "UInt16": "u2", "UInt32": "u4", "UInt64": "u8",
}  # fmt: skip
_MOST_SETS = 1000
# Largest compression ratio of zlib; larger stated sizes are rejected.
_BEST_PACKED = 1032


@dataclass(frozen=True)
class _File:
    """Byte order, compression and appended data of a file."""

    path: Path
    order: str
    header: np.dtype
    packed: bool
    appended: bytes
    is_raw: bool

    def error(self, message: str) -> ImportFormatError:
        """The error for a file that is not readable as VTU."""
        return ImportFormatError(f"{self.path}: not readable as VTU: {message}; write it again")


@checked_arguments
def read_vtu(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of a VTU file: its cells of the highest dimension; several pieces are one mesh.

    Points of different pieces with equal coordinates are one node. Ghost cells are omitted.

    Each value of an integer array NAME on cells defines a cell set and a node set NAME_VALUE. An array with
    more than 1000 different values in a piece defines no sets. An integer array NAME of values 0 and 1 on
    points defines a node set NAME of the points with 1.

    Parameters and errors are those of `read_mesh`; also ImportFormatError for compression other than zlib.
    """
    path = Path(path)
    file, root = _opened(path)
    points, blocks, node_sets, start, first_id = [], [], {}, 0, 1
    for piece in root.iter("Piece"):
        x = _array(file, piece.find("Points/DataArray"), "the points").astype(np.float64)
        if x.size % 3:
            raise file.error(f"{x.size} coordinates of points; each point needs three")
        x = x.reshape(-1, 3)
        if not np.isfinite(x).all():
            raise file.error("a point with a coordinate that is not a number")
        found = _blocks(file, piece, start, len(x), first_id)
        points.append(x)
        blocks += found
        for name, values in _integers(file, piece, "PointData", len(x)).items():
            if name != _GHOST and np.isin(values, (0, 1)).all() and values.any():
                inside = start + np.flatnonzero(values)
                node_sets[name] = np.concatenate([node_sets.get(name, inside[:0]), inside])
        start += len(x)
        first_id = max((int(block.ids[-1]) + 1 for block in found), default=first_id)
    if not points:
        raise file.error("no Piece with cells")
    nodes, number = _joined(points)
    blocks = [replace(each, cells=number[each.cells]) for each in blocks]
    node_sets = {name: np.unique(number[inside]) for name, inside in node_sets.items()}
    return file_mesh(path, nodes, _reoriented(nodes, blocks), node_sets).to_mesh(
        only=only, unused_nodes=unused_nodes
    )


def _joined(points: list[FloatArray]) -> tuple[FloatArray, IntArray]:
    """Nodes (N, 3) of all pieces, and the node number of each of their points.

    A point of a piece is a node of an earlier piece if the coordinates are equal, as pieces repeat the points
    of their common border. Equal points within a piece stay apart.
    """
    every = np.concatenate(points)
    if len(points) == 1:
        return every, np.arange(len(every))
    piece = np.repeat(np.arange(len(points)), [len(x) for x in points])
    _, place = np.unique(every, axis=0, return_inverse=True)
    place = place.ravel()
    _, which, count = np.unique(np.stack([place, piece]), axis=1, return_inverse=True, return_counts=True)
    apart = np.isin(place, place[count[which.ravel()] > 1])
    key = np.where(apart, place.max() + 1 + np.arange(len(every)), place)
    _, first, own = np.unique(key, return_index=True, return_inverse=True)
    order = np.argsort(first)
    return every[first[order]], np.argsort(order)[own.ravel()]


def _opened(path: Path) -> tuple[_File, ElementTree.Element]:
    content = file_content(path)
    raw, is_raw = b"", False
    start = re.search(rb"<AppendedData[^>]*>\s*_", content)
    if start is not None:
        end = content.rfind(b"</AppendedData>")
        is_raw = b"base64" not in start[0]
        raw = content[start.end() : end]
        content = content[: start.end() - 1] + content[max(end, 0) :]
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise ImportFormatError(f"{path}: not readable as VTU: it declares entities; write it again")
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise ImportFormatError(
            f"{path}: not readable as VTU: no well-formed XML ({error}); is it cut short? Write it again"
        ) from error
    if root.tag != "VTKFile" or root.get("type") != "UnstructuredGrid":
        raise ImportFormatError(
            f"{path}: a {root.get('type', root.tag)} file; write an UnstructuredGrid (.vtu) of one piece or "
            "more"
        )
    packing = root.get("compressor", "")
    if packing not in ("", "vtkZLibDataCompressor"):
        raise ImportFormatError(
            f"{path}: compressed by {packing}; write it uncompressed, or compressed by zlib"
        )
    order = ">" if root.get("byte_order") == "BigEndian" else "<"
    header = np.dtype(f"{order}{_KINDS.get(root.get('header_type', 'UInt32'), 'u4')}")
    return _File(path, order, header, bool(packing), raw, is_raw), root


def _array(file: _File, element: ElementTree.Element | None, what: str) -> NDArray:
    """The numbers of a DataArray."""
    if element is None:
        raise file.error(f"{what} are missing")
    kind = np.dtype(file.order + _KINDS[element.get("type", "")]) if element.get("type") in _KINDS else None
    if kind is None:
        raise file.error(f"{what} are of type {element.get('type')}")
    form = element.get("format", "ascii")
    try:
        if form == "ascii":
            return np.array((element.text or "").split(), dtype=kind)
        if form == "appended":
            offset = int(element.get("offset", ""))
            data = file.appended[offset:] if file.is_raw else file.appended
            content = _unpacked(file, data, offset if not file.is_raw else None)
        else:
            content = _unpacked(file, "".join((element.text or "").split()).encode(), 0)
        return np.frombuffer(content, dtype=kind)
    except (ValueError, OverflowError, binascii.Error, zlib.error, IndexError) as error:
        raise file.error(f"{what} are broken ({error})") from error


def _unpacked(file: _File, data: bytes, base64_at: int | None) -> bytes:
    """Bytes of an array after its header; base64_at: start of its characters, None for raw bytes."""
    n = file.header.itemsize

    def read(start: int, count: int) -> bytes:
        if base64_at is None:
            found = data[start : start + count]
        else:  # header and data are encoded separately
            characters = data[base64_at + start : base64_at + start + -(-count // 3) * 4]
            found = base64.b64decode(characters, validate=True)[:count]
        if len(found) < count:
            raise ValueError("cut short")
        return found

    def taken(count: int) -> int:
        return count if base64_at is None else -(-count // 3) * 4

    if not file.packed:
        size = int(np.frombuffer(read(0, n), file.header)[0])
        return read(0, n + size)[n:]
    blocks = int(np.frombuffer(read(0, n), file.header)[0])
    if blocks * n > len(data):
        raise ValueError(f"{blocks} blocks")
    head = np.frombuffer(read(0, (3 + blocks) * n), file.header).astype(np.int64)
    block, last, sizes = int(head[1]), int(head[2]), head[3:]
    packed = read(taken((3 + blocks) * n), int(sizes.sum()))
    most = block * (blocks - 1) + (last or block) if blocks else 0
    if most > _BEST_PACKED * max(len(packed), 1):
        raise ValueError(f"{most} bytes in {len(packed)}")
    parts, start = [], 0
    for size in sizes.tolist():
        parts.append(zlib.decompressobj().decompress(packed[start : start + size], max(block, last, 1)))
        start += size
    return b"".join(parts)


def _blocks(
    file: _File, piece: ElementTree.Element, start: int, n_points: int, first_id: int
) -> list[CellBlock]:
    arrays = {each.get("Name"): each for each in piece.iterfind("Cells/DataArray")}
    connectivity, offsets, types = (
        _array(file, arrays.get(name), f"{name} of the cells").astype(np.int64)
        for name in ("connectivity", "offsets", "types")
    )
    if len(offsets) != len(types) or (len(offsets) and offsets[-1] != len(connectivity)):
        raise file.error(
            f"{len(types)} cell types, {len(offsets)} offsets, {len(connectivity)} nodes of cells"
        )
    counts = np.diff(offsets, prepend=0)
    numbers = _integers(file, piece, "CellData", len(types))
    ghost = numbers.pop(_GHOST, np.zeros(len(types), dtype=np.int64)) & 1 > 0
    blocks = []
    for kind in np.unique(types).tolist():
        own = np.flatnonzero((types == kind) & ~ghost)
        if kind == _VERTEX or not len(own):
            continue
        name, k = _TYPES.get(kind, (f"VTK {kind}", int(counts[own[0]])))
        if (counts[own] != k).any():
            raise file.error(f"a {name} cell of {counts[own][counts[own] != k][0]} nodes")
        cells = connectivity[(offsets[own] - k)[:, None] + np.arange(k)]
        if not 0 <= cells.min() <= cells.max() < n_points:
            raise file.error(f"{name} cells name node {cells.max()} (from 0) of {n_points}")
        sets = {
            f"{label}_{value}": values[own] == value
            for label, values in numbers.items()
            if len(np.unique(values)) <= _MOST_SETS
            for value in np.unique(values[own]).tolist()
        }
        blocks.append(CellBlock(name, start + cells, first_id + own, sets))
    return blocks


def _integers(file: _File, piece: ElementTree.Element, where: str, n: int) -> dict[str, IntArray]:
    """Arrays of one integer per cell or point, by name."""
    found = {}
    for each in piece.iterfind(f"{where}/DataArray"):
        if each.get("NumberOfComponents", "1") not in ("1", "") or "Int" not in each.get("type", ""):
            continue
        values = _array(file, each, f"the numbers '{each.get('Name')}'").astype(np.int64)
        if len(values) == n:
            found[str(each.get("Name"))] = values
    return found


def _reoriented(nodes: FloatArray, blocks: list[CellBlock]) -> list[CellBlock]:
    """The blocks; wedges of negative volume get the mirrored order of their nodes."""
    result = []
    for block in blocks:
        cells = block.cells
        if block.type_name in ("wedge", "wedge15"):
            x = nodes[cells[:, :4]] - nodes[cells[:, :1]]
            inverted = np.einsum("ei,ei->e", np.cross(x[:, 1], x[:, 2]), x[:, 3]) < 0
            order = mirrored_order(CellType.WEDGE6 if cells.shape[1] == 6 else CellType.WEDGE15)
            cells = np.where(inverted[:, None], cells[:, order], cells)
        result.append(replace(block, cells=cells))
    return result
