"""Labelled matrices: stiffness, mass or damping with rows identified by node id and component."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array, csc_array

from supple.arrays import FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.plain_number import is_plain

__all__ = ["LabelledMatrix", "MatrixRole", "freedom_name"]

_EXPONENT = re.compile(r"(?:[ED][+-]?|[+-])\d+$")
COMPONENT_NAMES = ("", "ux", "uy", "uz", "rx", "ry", "rz")

# Relative error of single precision.
SINGLE_PRECISION = float(np.finfo(np.float32).eps)

# Largest difference of mirrored entries, relative to the largest entry, in a symmetric matrix; 4 times the
# resolution if that is larger. A larger difference raises ImportFormatError.
SYMMETRY = 1e-9


class MatrixRole(Enum):
    """Role of a matrix.

    label : its name in messages and HDF5 files;  letter : first letter of its name in DMIG and OUTPUT4 files
    """

    STIFFNESS = ("stiffness", "K")
    MASS = ("mass", "M")
    DAMPING = ("damping", "B")

    def __init__(self, label: str, letter: str) -> None:
        self.label = label
        self.letter = letter


@dataclass(frozen=True, eq=False)
class LabelledMatrix:
    """A symmetric matrix with the freedom of each row and column.

    source     : origin, for messages
    matrix     : csc (n, n)
    freedoms   : (n, 2) node id and component (1 to 3 translations, 4 to 6 rotations; 0 a scalar
                 point or modal coordinate), each once
    resolution : relative error of an entry by its printed digits or number type

    Raises
    ------
    ImportFormatError   a size other than that of the freedoms; freedoms given twice or with a component
                        outside 0 to 6; entries that are not finite; an unsymmetric matrix
    """

    source: str
    matrix: csc_array = field(repr=False)
    freedoms: IntArray = field(repr=False)
    resolution: float = float(np.finfo(float).eps)

    def __post_init__(self) -> None:
        n = len(self.freedoms)
        if self.matrix.shape != (n, n):
            raise ImportFormatError(
                f"{self.source}: the matrix has shape {self.matrix.shape}, but its map names {n} freedoms; "
                "export both from the same model and set"
            )
        wrong = np.flatnonzero((self.freedoms[:, 1] < 0) | (self.freedoms[:, 1] > 6))
        if wrong.size:
            node, component = self.freedoms[wrong[0]]
            raise ImportFormatError(
                f"{self.source}: component {component} of node {node}; only 1 to 6 are motions of a node, "
                "and 0 is a scalar point or modal coordinate; correct the map"
            )
        unique, counts = np.unique(self.freedoms, axis=0, return_counts=True)
        if len(unique) < n:
            node, component = unique[counts > 1][0]
            raise ImportFormatError(
                f"{self.source}: {freedom_name(node, component)} occurs twice in the map; name each "
                "freedom once"
            )
        self._check_entries()

    def _check_entries(self) -> None:
        bad = np.flatnonzero(~np.isfinite(self.matrix.data))
        if bad.size:
            place = freedom_name(*self.freedoms[self.matrix.indices[bad[0]]])
            raise ImportFormatError(
                f"{self.source}: an entry in the row of {place} is not finite; export it again"
            )
        difference = abs(self.matrix - self.matrix.T).tocoo()
        largest = float(abs(self.matrix.data).max(initial=0.0))
        if difference.nnz and difference.data.max() > max(SYMMETRY, 4 * self.resolution) * largest:
            worst = int(np.argmax(difference.data))
            row, column = (freedom_name(*self.freedoms[i[worst]]) for i in (difference.row, difference.col))
            raise ImportFormatError(
                f"{self.source}: not symmetric: the two entries of {row} with {column} differ by "
                f"{difference.data[worst] / largest:.1e} of the largest; export the structural matrix "
                "alone, without gyroscopic, follower or control terms"
            )


def freedom_name(node: int, component: int) -> str:
    """A freedom in words."""
    return f"node {node} {COMPONENT_NAMES[component]}" if component else f"modal coordinate {node}"


def chosen_name(
    path: Path, names: Iterable[str], role: MatrixRole, name: str | None, *, one: str, several: str
) -> str:
    """The given name, or the only name that begins with the letter of a role; all in upper case.

    one, several : words for the matrices of a file in messages
    """
    known = [each.upper() for each in names]
    listed = ", ".join(known) or "none"
    if name is not None:
        if name.upper() not in known:
            raise ImportFormatError(f"{path}: no {one} '{name}'; the file has {listed}")
        return name.upper()
    fitting = [each for each in known if each.startswith(role.letter)]
    if len(fitting) != 1:
        raise ImportFormatError(
            f"{path}: {len(fitting)} {several} whose name begins with {role.letter}, for the {role.label}; "
            f"name the one to take; the file has {listed}"
        )
    return fitting[0]


def from_labelled_entries(
    source: str, rows: IntArray, columns: IntArray, values: FloatArray, resolution: float
) -> LabelledMatrix:
    """Matrix from entries labelled by (node id, component), rows and columns (k, 2), in any order.

    Raises
    ------
    ImportFormatError   an entry given twice; errors of `LabelledMatrix`
    """
    labels = np.vstack([rows, columns])
    freedoms, number = np.unique(labels, axis=0, return_inverse=True)
    row, column = number.reshape(2, -1)
    matrix = from_entries(source, row, column, values, freedoms)
    return LabelledMatrix(source, matrix, freedoms, resolution)


def from_entries(
    source: str, row: IntArray, column: IntArray, values: FloatArray, freedoms: IntArray
) -> csc_array:
    """Matrix (n, n) from its entries; if no entry has its mirrored entry, the other triangle is added.

    Programs print one triangle in their own order of nodes, which need not be that of `freedoms`.

    Raises
    ------
    ImportFormatError   an entry given twice
    """
    n = len(freedoms)
    place, mirrored, off = row * n + column, column * n + row, row != column
    order = np.argsort(place, kind="stable")
    again = np.flatnonzero(np.diff(place[order]) == 0)
    if again.size:
        twice = order[again[0]]
        names = [freedom_name(*freedoms[i[twice]]) for i in (row, column)]
        raise ImportFormatError(
            f"{source}: the entry of {names[0]} with {names[1]} is given twice; give it once"
        )
    if not np.isin(place[off], mirrored[off]).any():
        row, column = np.concatenate([row, column[off]]), np.concatenate([column, row[off]])
        values = np.concatenate([values, values[off]])
    return csc_array(coo_array((values, (row, column)), shape=(n, n)))


def number_table(
    lines: Sequence[tuple[int, str]], rows: Sequence[Sequence[str]], width: int
) -> FloatArray | tuple[int, str]:
    """The words of lines as numbers (k, width); or the first line, with its number, of other words.

    rows : the words of each line
    """

    def is_row(text: str, row: Sequence[str]) -> bool:
        try:
            return is_plain(text) and len([float(word) for word in row]) == width
        except ValueError:
            return False

    try:
        if all(is_plain(text) for _, text in lines):
            return np.array(rows, dtype=np.float64).reshape(len(rows), width)
    except ValueError:
        pass
    return next(line for line, row in zip(lines, rows, strict=True) if not is_row(line[1], row))


def printed_resolution(word: str) -> float:
    """Relative resolution of a number with the digits of `word`: 5e-10 for -1.234567890E+05."""
    mantissa = _EXPONENT.sub("", word.strip().upper().lstrip("+-"))
    digits = len(mantissa.replace(".", "").lstrip("0"))
    return max(5.0 * 10.0**-digits, float(np.finfo(float).eps))
