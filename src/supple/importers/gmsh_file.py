"""Syntax of the Gmsh format (.msh; 2 and 4.1, in text also 4.0): nodes, elements, groups.

Every stated count is compared with the remaining size of the file before an array of that size is made.
Source: the Gmsh reference manual, chapter on file formats.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.numbering import first_repeated
from supple.importers.plain_number import is_plain

# Name, dimension and number of nodes of each of Gmsh's types, by its number.
_TYPES = {
    1: ("line", 1, 2), 2: ("triangle", 2, 3), 3: ("quad", 2, 4), 4: ("tetra", 3, 4), 5: ("hexahedron", 3, 8),
    6: ("wedge", 3, 6), 7: ("pyramid", 3, 5), 8: ("line3", 1, 3), 9: ("triangle6", 2, 6), 10: ("quad9", 2, 9),
    11: ("tetra10", 3, 10), 12: ("hexahedron27", 3, 27), 13: ("wedge18", 3, 18), 14: ("pyramid14", 3, 14),
    15: ("vertex", 0, 1), 16: ("quad8", 2, 8), 17: ("hexahedron20", 3, 20), 18: ("wedge15", 3, 15),
    19: ("pyramid13", 3, 13), 20: ("triangle9", 2, 9), 21: ("triangle10", 2, 10), 23: ("triangle15", 2, 15),
    26: ("line4", 1, 4), 27: ("line5", 1, 5), 28: ("line6", 1, 6), 29: ("tetra20", 3, 20),
    30: ("tetra35", 3, 35), 31: ("tetra56", 3, 56), 36: ("quad16", 2, 16), 37: ("quad25", 2, 25),
    92: ("hexahedron64", 3, 64), 93: ("hexahedron125", 3, 125),
}  # fmt: skip
# Position in Gmsh's order of each node of the library's order.
_ORDER = {
    "tetra10": (0, 1, 2, 3, 4, 5, 6, 7, 9, 8),
    "pyramid13": (0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12),
    "wedge15": (0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11),
    "hexahedron20": (0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15),
}
_ORDER |= {
    "hexahedron27": _ORDER["hexahedron20"], "wedge18": _ORDER["wedge15"], "pyramid14": _ORDER["pyramid13"],
}  # fmt: skip


@dataclass(frozen=True)
class GmshElements:
    """Elements of one type.

    type_name : name of the shape as in `CellType`;  dimension : 0 to 3
    ids : (E,) element tags;  nodes : (E, k) node tags
    groups : {physical tag: (E,) mask of the members}
    """

    type_name: str
    dimension: int
    ids: IntArray
    nodes: IntArray
    groups: dict[int, BoolArray]


def read_gmsh_file(path: Path, content: bytes) -> tuple[IntArray, FloatArray, tuple[GmshElements, ...]]:
    """Tags (N,) and positions (N, 3) of the nodes, and the elements, of a file with all required sections.

    Raises
    ------
    ImportFormatError   another format; counts that do not fit; words instead of numbers; repeated tags
    """
    version, numbers = _format(path, content)
    if version == "2":
        tags, positions = _nodes_of_2(numbers("Nodes"))
        blocks = tuple(_elements_of_2(numbers("Elements")))
    else:
        old = version == "4.0"
        tags, positions = _nodes_of_4(numbers("Nodes"), old=old)
        groups = _groups_of_4(numbers("Entities"), old=old) if b"$Entities" in content else {}
        blocks = tuple(_elements_of_4(numbers("Elements"), groups, old=old))
    second = first_repeated(tags)
    if second is not None:
        raise _unreadable(path, f"node {tags[second]} occurs twice in $Nodes")
    return tags, positions, blocks


def _unreadable(path: Path, why: str) -> ImportFormatError:
    return ImportFormatError(
        f"{path}: not readable as a Gmsh mesh ({why}); save the whole mesh from Gmsh again, as format "
        "2.2 or 4.1, with all entities in physical groups, or none"
    )


class _Section:
    """The numbers between `$Name` and `$EndName`, taken one after the other."""

    def __init__(
        self, path: Path, name: str, content: bytes, *, is_text: bool, order: str, size: int
    ) -> None:
        self._path, self._name, self._is_text, self._order = path, name, is_text, order
        self.size = size
        start = content.find(b"$" + name.encode())
        start = content.find(b"\n", start) + 1
        self._bytes = content[start : content.find(b"$End" + name.encode(), start)]
        self._place = 0
        self._words: list[bytes] = []
        if is_text:
            if not is_plain(self._bytes.decode("latin-1")):
                raise self.error("characters that are part of no number")
            self._words = self._bytes.split()

    def error(self, why: str) -> ImportFormatError:
        """The error for a mistake in this section."""
        return _unreadable(self._path, f"${self._name}: {why}")

    @property
    def lines(self) -> list[bytes] | None:
        """Lines below the first that are not blank, in a text file; None in a binary file."""
        return [line for line in self._bytes.splitlines()[1:] if line.strip()] if self._is_text else None

    def count_in_text(self) -> int:
        """The number on its first line, which is text in binary files as well."""
        if self._is_text:
            return self.integer()
        end = self._bytes.find(b"\n") + 1
        self._place = end
        return int(self.converted([self._bytes[:end].strip()], np.int64)[0])

    def integer(self, *, wide: bool = False) -> int:
        """One whole number, of 4 bytes or, if `wide`, of the size of a count."""
        return int(self.integers(1, wide=wide)[0])

    def integers(self, n: int, *, wide: bool = False) -> IntArray:
        """The next `n` whole numbers."""
        size = self.size if wide else 4
        kind = "u" if wide else "i"
        return self._taken(n, f"{self._order}{kind}{size}", np.int64)

    def reals(self, n: int) -> FloatArray:
        """The next `n` numbers."""
        return self._taken(n, f"{self._order}f8", np.float64)

    def converted(self, words: list[bytes], dtype: type) -> NDArray:
        """Words of the text as numbers."""
        try:
            return np.array(
                [dtype(float(word)) if dtype is np.float64 else int(word) for word in words], dtype
            )
        except (ValueError, OverflowError) as error:
            raise self.error(str(error)[:100]) from error

    def words(self, n: int) -> list[bytes]:
        """The next `n` words of a text."""
        if not 0 <= n <= len(self._words) - self._place:
            raise self.error(f"{n} numbers are declared, and {len(self._words) - self._place} are left")
        self._place += n
        return self._words[self._place - n : self._place]

    def _taken(self, n: int, layout: str, dtype: type) -> NDArray:
        if not self._is_text:
            found = self.table(n, np.dtype(layout))
            if found.dtype.kind == "u" and (found > np.iinfo(np.int64).max).any():
                raise self.error("a tag or count beyond 64 bits")
            return found.astype(dtype)
        return self.converted(self.words(n), dtype)

    def table(self, n: int, layout: np.dtype) -> NDArray:
        """The next `n` rows with this layout, in a binary file."""
        left = len(self._bytes) - self._place
        if not 0 <= n <= left // layout.itemsize:
            raise self.error(
                f"{n} entries of {layout.itemsize} bytes are declared, and {left} bytes are left"
            )
        found = np.frombuffer(self._bytes, layout, n, self._place)
        self._place += n * layout.itemsize
        return found


def _format(path: Path, content: bytes):
    """The format (2, 4 or 4.0), and a function that returns a section by its name."""
    header = re.search(
        rb"\$MeshFormat\s*?\n\s*([0-9.]{1,8})\s+([01])\s+(\d{1,2})[ \t]*\r?\n(.{4})", content, re.DOTALL
    )
    if header is None:
        raise _unreadable(path, "$MeshFormat: not a version, a file type and a size")
    version, is_text, size = header[1].decode(), header[2] == b"0", int(header[3])
    known = {"2": "2", "2.0": "2", "2.1": "2", "2.2": "2", "4": "4", "4.1": "4", "4.0": "4.0"}.get(version)
    if known is None or (known == "4.0" and not is_text) or size not in (4, 8):
        raise _unreadable(path, f"its format is {version} with counts of {size} bytes")
    order = "<" if is_text or header[4] == b"\1\0\0\0" else ">"
    if not is_text and header[4] not in (b"\1\0\0\0", b"\0\0\0\1"):
        raise _unreadable(path, "$MeshFormat: the order of bytes is not stated")

    def numbers(name: str) -> _Section:
        return _Section(path, name, content, is_text=is_text, order=order, size=size)

    return known, numbers


def _type(section: _Section, number: int) -> tuple[str, int, int]:
    if number not in _TYPES:
        raise section.error(f"an element of the unknown type {number}")
    return _TYPES[number]


def _elements(
    section: _Section, number: int, ids: IntArray, nodes: IntArray, groups: dict[int, BoolArray]
) -> GmshElements:
    name, dimension, _ = _type(section, number)
    order = _ORDER.get(name, ())
    ordered = nodes[:, [*order, *range(len(order), nodes.shape[1])]]
    return GmshElements(name, dimension, ids, ordered, groups)


def _nodes_of_2(section: _Section) -> tuple[IntArray, FloatArray]:
    n = section.count_in_text()
    lines = section.lines
    if lines is None:
        rows = section.table(
            n, np.dtype([("tag", f"{section._order}i4"), ("x", f"{section._order}f8", (3,))])
        )
        return rows["tag"].astype(np.int64), rows["x"].astype(np.float64)
    words = [line.split() for line in lines]
    if len(words) != n or any(len(row) != 4 for row in words):
        raise section.error(
            f"{n} nodes are declared, and {len(words)} lines follow, or not all are of 4 numbers"
        )
    positions = section.converted([word for row in words for word in row[1:]], np.float64)
    return section.converted([row[0] for row in words], np.int64), positions.reshape(n, 3)


def _elements_of_2(section: _Section) -> Iterator[GmshElements]:
    """Elements in blocks of one type; the first tag of an element is its physical group."""
    n = section.count_in_text()
    lines = section.lines
    if lines is None:
        yield from _binary_elements_of_2(section, n)
        return
    words = [line.split() for line in lines]
    counts = np.array([len(row) for row in words], dtype=np.int64)
    if len(words) != n or (counts < 3).any():
        raise section.error(
            f"{n} elements are declared, and {len(words)} lines follow, or not all are elements"
        )
    flat = section.converted([word for row in words for word in row], np.int64)
    starts = np.cumsum(counts) - counts
    types, n_tags = flat[starts + 1], flat[starts + 2]
    for number in dict.fromkeys(types.tolist()):
        k = _type(section, number)[2]
        of_type = np.flatnonzero(types == number)
        if (n_tags[of_type] < 0).any() or (counts[of_type] != 3 + n_tags[of_type] + k).any():
            raise section.error(f"an element of type {number} without its {k} nodes")
        ends = starts[of_type] + counts[of_type]
        physical = np.where(n_tags[of_type] > 0, flat[np.minimum(starts[of_type] + 3, len(flat) - 1)], 0)
        nodes = flat[ends[:, None] + np.arange(-k, 0)]
        yield _elements(section, number, flat[starts[of_type]], nodes, _groups_of_tags(physical))


def _binary_elements_of_2(section: _Section, n: int) -> Iterator[GmshElements]:
    read = 0
    while read < n:
        number, count, n_tags = section.integers(3).tolist()
        k = _type(section, number)[2]
        if count < 1 or not 0 <= n_tags <= 1000:
            raise section.error(f"a block of {count} elements with {n_tags} tags each")
        rows = section.integers(count * (1 + n_tags + k)).reshape(count, -1)
        physical = rows[:, 1] if n_tags else np.zeros(count, dtype=np.int64)
        yield _elements(section, number, rows[:, 0], rows[:, 1 + n_tags :], _groups_of_tags(physical))
        read += count


def _groups_of_tags(physical: IntArray) -> dict[int, BoolArray]:
    return {tag: np.abs(physical) == tag for tag in np.unique(np.abs(physical)).tolist() if tag}


def _nodes_of_4(section: _Section, *, old: bool) -> tuple[IntArray, FloatArray]:
    """Tags and positions; in format 4.0, which is text, each row has a tag and three coordinates."""
    n_blocks, n = section.integers(2 if old else 4, wide=True).tolist()[:2]
    tags, positions = [np.zeros(0, dtype=np.int64)], [np.zeros((0, 3))]
    for _ in range(n_blocks):  # each reads part of the section: a false count is an error
        _, _, parametric = section.integers(3).tolist()
        if parametric:
            raise section.error("parametric nodes; save the mesh without them")
        count = section.integer(wide=True)
        if old:
            rows = section.words(4 * count)
            tags.append(section.converted(rows[::4], np.int64))
            words = [word for i, word in enumerate(rows) if i % 4]
            positions.append(section.converted(words, np.float64).reshape(-1, 3))
        else:
            tags.append(section.integers(count, wide=True))
            positions.append(section.reals(3 * count).reshape(-1, 3))
    found = np.concatenate(tags)
    if len(found) != n:
        raise section.error(f"{n} nodes are declared, and {len(found)} follow")
    return found, np.concatenate(positions)


def _groups_of_4(section: _Section, *, old: bool) -> dict[tuple[int, int], list[int]]:
    """Physical tags of each entity, by its dimension and tag."""
    found: dict[tuple[int, int], list[int]] = {}
    for dimension, count in enumerate(section.integers(4, wide=True).tolist()):
        for _ in range(count):
            tag = section.integer()
            section.reals(6 if dimension or old else 3)  # its bounding box or position
            found[dimension, tag] = np.abs(section.integers(section.integer(wide=True))).tolist()
            if dimension:
                section.integers(section.integer(wide=True))  # its boundary
    return found


def _elements_of_4(
    section: _Section, groups: dict[tuple[int, int], list[int]], *, old: bool
) -> Iterator[GmshElements]:
    n_blocks, n = section.integers(2 if old else 4, wide=True).tolist()[:2]
    read = 0
    for _ in range(n_blocks):
        dimension, entity, number = section.integers(3).tolist()
        if old:  # format 4.0 writes the entity first
            dimension, entity = entity, dimension
        count, k = section.integer(wide=True), _type(section, number)[2]
        rows = section.integers(count * (1 + k), wide=True).reshape(-1, 1 + k)
        if groups and (dimension, entity) not in groups:
            raise section.error(f"entity {entity} of dimension {dimension} is not in $Entities")
        inside = {tag: np.ones(count, dtype=bool) for tag in groups.get((dimension, entity), []) if tag}
        yield _elements(section, number, rows[:, 0], rows[:, 1:], inside)
        read += count
    if read != n:
        raise section.error(f"{n} elements are declared, and {read} follow")
