"""Tags of a Gmsh file: what it calls its nodes and elements, in the order in which they stand in it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]

# Nodes of an element by Gmsh's number of its type, of the types that may stand in a mesh file.
_N_NODES = {
    1: 2, 2: 3, 3: 4, 4: 4, 5: 8, 6: 6, 7: 5, 8: 3, 9: 6, 10: 9, 11: 10, 12: 27, 13: 18, 14: 14, 15: 1,
    16: 8, 17: 20, 18: 15, 19: 13,
}  # fmt: skip


class GmshTags(NamedTuple):
    """Tags of nodes (N,) and of elements (E,) of all dimensions."""

    nodes: IntArray
    elements: IntArray


def read_gmsh_tags(path: Path) -> GmshTags | None:
    """The tags of a file of format 2, 4.0 (text) or 4.1; None where another one or a rare element hides them.

    A file that meshio reads is taken to be sound: its checks are not repeated.
    """
    content = path.read_bytes()
    version, kind, size = _section(content, "MeshFormat").split()[:3]
    is_binary, size = kind == b"1", int(size)
    nodes, elements = _section(content, "Nodes"), _section(content, "Elements")
    try:
        if version.startswith(b"2"):
            read = _binary2 if is_binary else _text2
            return read(nodes, elements)
        if version == b"4.0" and not is_binary:
            return _text40(_Text(nodes), _Text(elements))
        if version in (b"4", b"4.1"):
            real, whole = np.dtype("f8"), np.dtype(f"u{size}")
            cursors = (
                (_Binary(nodes, whole, real), _Binary(elements, whole, real))
                if is_binary
                else (_Text(nodes), _Text(elements))
            )
            return GmshTags(_blocks_of_nodes(cursors[0]), _blocks_of_elements(cursors[1]))
    except KeyError:
        return None
    return None


def _section(content: bytes, name: str) -> bytes:
    start = content.index(b"$" + name.encode())
    start = content.index(b"\n", start) + 1
    return content[start : content.index(b"$End" + name.encode(), start)]


def _text2(nodes: bytes, elements: bytes) -> GmshTags:
    """Rows `tag x y z`, and `tag type number-of-tags tags nodes`, under the number of rows."""
    first = [np.fromstring(line.split(None, 1)[0], dtype=np.int64, sep=" ") for line in _rows(nodes)]
    of_elements = [np.fromstring(line.split(None, 1)[0], dtype=np.int64, sep=" ") for line in _rows(elements)]
    return GmshTags(np.concatenate(first), np.concatenate(of_elements))


def _text40(nodes: _Text, elements: _Text) -> GmshTags:
    """Blocks under `tag dimension - count` of rows `tag x y z`, and `tag nodes` of elements of one type."""
    found: tuple[list[IntArray], list[IntArray]] = ([], [])
    for cursor, tags in zip((nodes, elements), found, strict=True):
        for _ in range(int(cursor.sizes(2)[0])):
            _, _, kind, count = cursor.integers(4)
            width = 4 if cursor is nodes else 1 + _N_NODES[kind]
            tags.append(cursor.sizes(count * width).reshape(count, width)[:, 0])
    return GmshTags(*(np.concatenate(tags) for tags in found))


def _rows(section: bytes) -> list[bytes]:
    return [line for line in section.splitlines() if line.strip()][1:]


def _binary2(nodes: bytes, elements: bytes) -> GmshTags:
    count, _, rows = nodes.partition(b"\n")
    node = np.dtype([("tag", "i4"), ("place", "f8", 3)])
    tags = np.frombuffer(rows, node, int(count))["tag"].astype(np.int64)
    total, _, rest = elements.partition(b"\n")
    found, place, seen = [], 0, 0
    while seen < int(total):
        kind, number, n_tags = np.frombuffer(rest, "i4", 3, place).tolist()
        width = 1 + n_tags + _N_NODES[kind]
        block = np.frombuffer(rest, "i4", number * width, place + 12).reshape(number, width)
        found.append(block[:, 0].astype(np.int64))
        place, seen = place + 12 + 4 * number * width, seen + number
    return GmshTags(tags, np.concatenate(found))


class _Text:
    """Numbers of a section in text, taken from the front."""

    def __init__(self, section: bytes) -> None:
        self._numbers = np.array(section.split(), dtype=np.float64)
        self._at = 0

    def integers(self, count: int) -> list[int]:
        return self._taken(count).astype(np.int64).tolist()

    def sizes(self, count: int) -> IntArray:
        return self._taken(count).astype(np.int64)

    def skip_reals(self, count: int) -> None:
        self._at += count

    def _taken(self, count: int) -> NDArray[np.float64]:
        self._at += count
        return self._numbers[self._at - count : self._at]


class _Binary:
    """The same of a section in bytes; `int` has four bytes, a size as many as the file says."""

    def __init__(self, section: bytes, whole: np.dtype, real: np.dtype) -> None:
        self._section, self._whole, self._real = section, whole, real
        self._at = 0

    def integers(self, count: int) -> list[int]:
        return self._taken(np.dtype("i4"), count).tolist()

    def sizes(self, count: int) -> IntArray:
        return self._taken(self._whole, count).astype(np.int64)

    def skip_reals(self, count: int) -> None:
        self._at += self._real.itemsize * count

    def _taken(self, kind: np.dtype, count: int) -> NDArray:
        start, self._at = self._at, self._at + kind.itemsize * count
        return np.frombuffer(self._section, kind, count, start)


def _blocks_of_nodes(cursor: _Text | _Binary) -> IntArray:
    n_blocks = int(cursor.sizes(4)[0])
    found = [np.empty(0, dtype=np.int64)]
    for _ in range(n_blocks):
        cursor.integers(3)
        count = int(cursor.sizes(1)[0])
        found.append(cursor.sizes(count))
        cursor.skip_reals(3 * count)
    return np.concatenate(found)


def _blocks_of_elements(cursor: _Text | _Binary) -> IntArray:
    n_blocks = int(cursor.sizes(4)[0])
    found = [np.empty(0, dtype=np.int64)]
    for _ in range(n_blocks):
        kind = cursor.integers(3)[2]
        count, width = int(cursor.sizes(1)[0]), 1 + _N_NODES[kind]
        found.append(cursor.sizes(count * width).reshape(count, width)[:, 0])
    return np.concatenate(found)
