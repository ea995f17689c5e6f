"""VTK's unstructured grids in XML (.vtu): text, binary or appended, compressed by zlib or LZMA.

Source: VTK file formats (the XML formats), https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
"""

from __future__ import annotations

import base64
import lzma
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.errors import ImportFormatError
from supple.importers.cell_file import CellElements, cell_elements, cell_file_mesh, without_inner_nodes
from supple.importers.file_mesh import UnusedNodes
from supple.importers.plain_number import is_plain
from supple.importers.text_file import file_content
from supple.mesh import Mesh

__all__ = ["read_vtu"]

IntArray = NDArray[np.int64]

# Number of the type: name, dimension, nodes.
_TYPES = {
    1: ("vertex", 0, 1), 3: ("line", 1, 2), 5: ("triangle", 2, 3), 9: ("quad", 2, 4), 10: ("tetra", 3, 4),
    12: ("hexahedron", 3, 8), 13: ("wedge", 3, 6), 14: ("pyramid", 3, 5), 21: ("line3", 1, 3),
    22: ("triangle6", 2, 6), 23: ("quad8", 2, 8), 24: ("tetra10", 3, 10), 25: ("hexahedron20", 3, 20),
    26: ("wedge15", 3, 15), 27: ("pyramid13", 3, 13), 28: ("quad9", 2, 9), 29: ("hexahedron27", 3, 27),
    32: ("wedge18", 3, 18),
}  # fmt: skip
_NUMBERS = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4", "Int64": "i8",
    "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
_DECOMPRESSORS = {"vtkZLibDataCompressor": zlib.decompressobj, "vtkLZMADataCompressor": lzma.LZMADecompressor}
# Wedges of VTK's manual have their base outward; turned, they list it as ours do.
_TURNED_WEDGE = [0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13]
_LARGEST = 2**31
_MOST_VALUES = 200
"""Of an array of whole numbers that makes sets; more are ids."""


@checked_arguments
def read_vtu(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of a VTK unstructured grid: its cells of the highest dimension; whole numbers on them as sets.

    Each value of such an array of cells or points makes a set, 'NAME VALUE'; one of zeros and ones makes the
    set NAME of its ones. Sets of cells are node sets as well. Surfaces and inner nodes as in `read_gmsh`.

    Parameters
    ----------
    path : str or Path
    only : str or None            a set of cells: read it and its nodes alone; None reads everything
    unused_nodes : UnusedNodes    REFUSE or DROP nodes that no cell uses
    Returns
    -------
    Mesh   nodes in the order of the file
    Raises
    ------
    ImportFormatError   missing, cut or unreadable file, unknown cell type, cells naming missing points
    MeshError           what the file describes is no usable mesh
    """
    path = Path(path)
    try:
        pieces = list(_File.of(file_content(path)).pieces())
    except (
        ArithmeticError,
        ValueError,
        KeyError,
        zlib.error,
        lzma.LZMAError,
        ElementTree.ParseError,
    ) as error:
        raise ImportFormatError(
            f"{path}: not readable as a VTK unstructured grid ({str(error)[:150]}); save it anew as .vtu"
        ) from error
    points = np.concatenate([np.empty((0, 3)), *(piece.points for piece in pieces)])
    names: dict[str, int] = {}
    blocks: list[CellElements] = []
    node_sets: dict[str, list[IntArray]] = {}
    first_point = first_cell = 0
    for piece in pieces:
        sets = {names.setdefault(name, len(names) + 1): inside for name, inside in _sets(piece.of_cells)}
        for name, inside in _sets(piece.of_points):
            node_sets.setdefault(name, []).append(first_point + np.flatnonzero(inside))
        for number in np.unique(piece.types).tolist():
            if number not in _TYPES:
                raise ImportFormatError(f"{path}: cells of VTK's type {number} are not read; remove them")
            which = np.flatnonzero(piece.types == number)
            nodes = piece.cells(which, _TYPES[number][2], path)
            if number in (13, 26, 32):
                nodes = _outward(piece.points, nodes)
            groups = {tag: inside[which] for tag, inside in sets.items() if inside[which].any()}
            name, dimension, _ = _TYPES[number]
            blocks.append(cell_elements(name, dimension, first_cell + which, first_point + nodes, groups))
        first_point += len(piece.points)
        first_cell += len(piece.types)
    file = without_inner_nodes(np.arange(len(points)), points, tuple(blocks))
    of_dimensions = {(dimension, tag): name for name, tag in names.items() for dimension in range(4)}
    listed = {name: np.concatenate(found) for name, found in node_sets.items()}
    return cell_file_mesh(path, file, of_dimensions, only=only, unused_nodes=unused_nodes, node_sets=listed)


@dataclass(frozen=True, eq=False)
class _Piece:
    """points (N, 3); connectivity, and the end of each cell in it; types (E,); arrays of whole numbers."""

    points: NDArray[np.float64]
    connectivity: IntArray
    ends: IntArray
    types: IntArray
    of_points: dict[str, IntArray]
    of_cells: dict[str, IntArray]

    def cells(self, which: IntArray, n: int, path: Path) -> IntArray:
        """Point numbers (k, n) of some cells."""
        starts = np.concatenate([[0], self.ends[:-1]])[which]
        if (
            (self.ends[which] - starts != n).any()
            or (starts < 0).any()
            or (starts + n > len(self.connectivity)).any()
        ):
            raise ImportFormatError(f"{path}: a cell of {n} points has other ones; save the file anew")
        return self.connectivity[starts[:, None] + np.arange(n)]


class _File:
    """The XML of a file, and the bytes appended to it."""

    def __init__(self, root: ElementTree.Element, appended: bytes, *, is_raw: bool) -> None:
        self._root, self._appended, self._is_raw = root, appended, is_raw
        order = "<" if root.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
        self._order, self._header = order, np.dtype(order + _NUMBERS[root.get("header_type", "UInt32")])
        compressor = root.get("compressor")
        if compressor and compressor not in _DECOMPRESSORS:
            raise ValueError(f"compressed by {compressor}; save it with zlib, or without compression")
        self._decompressor = _DECOMPRESSORS[compressor] if compressor else None
        self._left = _LARGEST

    @classmethod
    def of(cls, content: bytes) -> _File:
        """The parts of a file's content."""
        start = content.find(b"<AppendedData")
        appended, is_raw = b"", False
        if start >= 0:
            head = content[start : content.find(b">", start)]
            is_raw = b"raw" in head
            begin = content.find(b"_", start + len(head)) + 1
            appended = content[begin : content.rfind(b"</AppendedData>")]
            content = content[:start] + b"</VTKFile>"
        if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
            raise ValueError("it declares a document type")
        root = ElementTree.fromstring(content)
        if root.get("type") != "UnstructuredGrid":
            raise ValueError(f"a file of type {root.get('type')}")
        return cls(root, appended, is_raw=is_raw)

    def pieces(self) -> Iterator[_Piece]:
        """Its pieces, in their order."""
        for piece in self._root.iterfind("UnstructuredGrid/Piece"):
            cells = {
                each.get("Name", ""): self._array(each).astype(np.int64)
                for each in piece.iterfind("Cells/DataArray")
                if each.get("Name") in ("connectivity", "offsets", "types")
            }
            points = self._array(next(piece.iterfind("Points/DataArray"), None)).astype(np.float64)
            if points.size % 3 or len(cells["offsets"]) != len(cells["types"]):
                raise ValueError("points of other than three coordinates, or cells without a type")
            connectivity, n = cells["connectivity"], points.size // 3
            if connectivity.size and not 0 <= connectivity.min() <= connectivity.max() < n:
                raise ValueError(f"a cell names a point that is not there; there are {n}")
            yield _Piece(
                points.reshape(-1, 3),
                connectivity,
                cells["offsets"],
                cells["types"],
                self._integers(piece, "PointData", n),
                self._integers(piece, "CellData", len(cells["types"])),
            )

    def _integers(self, piece: ElementTree.Element, part: str, n: int) -> dict[str, IntArray]:
        found = {}
        for each in piece.iterfind(f"{part}/DataArray"):
            if "Int" in each.get("type", "") and each.get("NumberOfComponents", "1") in ("1", "0"):
                values = self._array(each).astype(np.int64)
                if len(values) == n:
                    found[each.get("Name", "")] = values
        return found

    def _array(self, element: ElementTree.Element | None) -> NDArray:
        if element is None:
            raise ValueError("an array is missing")
        dtype = np.dtype(self._order + _NUMBERS[element.get("type", "")])
        text, form = element.text or "", element.get("format", "ascii")
        if form == "ascii":
            if not is_plain(text):
                raise ValueError("characters that are part of no number")
            return np.array(text.split(), dtype=dtype)
        if form == "appended":
            data, is_raw = self._appended[int(element.get("offset", "0")) :], self._is_raw
        else:
            data, is_raw = text.strip().encode("ascii"), False
        content = self._decoded(data, is_raw=is_raw)
        return np.frombuffer(content[: len(content) // dtype.itemsize * dtype.itemsize], dtype)

    def _decoded(self, data: bytes, *, is_raw: bool) -> bytes:
        size = self._header.itemsize
        (first,) = self._counts(self._take(data, 0, size, is_raw=is_raw))
        if self._decompressor is None:
            self._spend(first)
            content = self._take(data, 0, size + first, is_raw=is_raw)[size:]
            if len(content) != first:
                raise ValueError(f"{first} bytes are announced, and {len(content)} are left")
            return content
        if first > len(data):
            raise ValueError(f"{first} blocks are announced, and {len(data)} bytes are left")
        n_header = size * (3 + first)
        _, whole, last, *sizes = self._counts(self._take(data, 0, n_header, is_raw=is_raw))
        body = data[n_header if is_raw else 4 * -(-n_header // 3) :]
        body = self._take(body, 0, sum(sizes), is_raw=is_raw)
        found, place = [], 0
        for k, packed in enumerate(sizes):
            wanted = last if last and k == len(sizes) - 1 else whole
            self._spend(wanted)
            block = self._decompressor().decompress(body[place : place + packed], max(wanted, 1))
            if len(block) != wanted:
                raise ValueError(f"a block of {wanted} bytes has {len(block)}")
            found.append(block)
            place += packed
        return b"".join(found)

    def _take(self, data: bytes, start: int, n: int, *, is_raw: bool) -> bytes:
        if is_raw:
            return data[start : start + n]
        return base64.b64decode(data[start : start + 4 * -(-n // 3)])[:n]

    def _counts(self, data: bytes) -> list[int]:
        counts = np.frombuffer(data, self._header).tolist()
        if not counts:
            raise ValueError("an array is cut short")
        return [int(count) for count in counts]

    def _spend(self, n: int) -> None:
        self._left -= n
        if n < 0 or self._left < 0:
            raise ValueError(f"its arrays hold more than {_LARGEST} bytes")


def _sets(arrays: dict[str, IntArray]) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    for name, values in arrays.items():
        distinct = np.unique(values)
        if not 1 <= len(distinct) <= _MOST_VALUES or 1 < len(distinct) == len(values):
            continue
        if np.isin(distinct, (0, 1)).all():
            if 1 in distinct:
                yield name, values == 1
            continue
        for value in distinct.tolist():
            yield f"{name} {value}", values == value


def _outward(points: NDArray[np.float64], wedges: IntArray) -> IntArray:
    """Wedges whose base turns about the direction to their top."""
    x = points[wedges[:, :6]]
    base = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    towards = x[:, 3:].mean(axis=1) - x[:, :3].mean(axis=1)
    inward = np.einsum("ei,ei->e", base, towards) < 0
    turned = wedges.copy()
    n = min(wedges.shape[1], 15)
    order = [place for place in _TURNED_WEDGE if place < n]
    turned[inward, :n] = wedges[inward][:, order]
    return turned
