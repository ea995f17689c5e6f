"""Matrix Market files (.mtx): matrices of a body reduced by another program, such as stiffness and mass."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array, csc_array

from supple.arrays import FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.matrices.labelled_matrix import number_table
from supple.importers.plain_number import plain_integer
from supple.importers.text_file import file_lines

__all__ = ["read_matrix"]

MOST_EMPTY = 100_000
"""Largest number by which the rows or columns of a sparse matrix exceed its entries; more are an error."""

_FORM = "write the complete matrix again, as coordinate real"


@dataclass(frozen=True)
class _Header:
    """The first lines of a file.

    line : number, from 1, of the line with the size
    entries : number of entries in the file; stated, or for the array format from the size
    """

    path: Path
    is_sparse: bool
    symmetry: str
    line: int
    rows: int
    columns: int
    entries: int

    def error(self, message: str, line: int | None = None) -> ImportFormatError:
        """The error for a mistake at a line; by default, at the line with the size."""
        return ImportFormatError(
            f"{self.path}: line {self.line if line is None else line}: not readable as Matrix Market: "
            f"{message}; {_FORM}"
        )


def read_matrix(path: str | Path) -> csc_array:
    """Real matrix of a Matrix Market file, coordinate or array format; symmetric storage is expanded.

    Raises
    ------
    ImportFormatError   missing, unreadable or cut file; a size that does not fit its entries; complex or
                        infinite entries, or NaN; an entry given twice
    Source: Boisvert, Pozo, Remington, The Matrix Market exchange formats, NISTIR 5935, 1996.
    """
    path = Path(path)
    lines = file_lines(path, "write it again as text, coordinate real")
    header = _header(path, lines)
    below = [
        (number, line)
        for number, line in enumerate(lines[header.line :], start=header.line + 1)
        if line.strip() and not line.startswith("%")
    ]
    numbers = _numbers(header, below, 3 if header.is_sparse else 1)
    if header.is_sparse:
        row, column, values = numbers.T
        row, column = _places(header, below, row, header.rows), _places(header, below, column, header.columns)
    else:
        row, column = _places_of_array(header)
        values = numbers[:, 0]
    if not np.isfinite(values).all():
        raise ImportFormatError(f"{path}: entries that are infinite or not a number; write the matrix again")
    return _filled_in(header, row, column, values)


def _header(path: Path, lines: list[str]) -> _Header:
    words = lines[0].lower().split() if lines else []
    if len(words) != 5 or words[0] != "%%matrixmarket" or words[1] != "matrix":
        raise ImportFormatError(
            f"{path}: not readable as Matrix Market: the first line is no %%MatrixMarket matrix FORM FIELD "
            f"SYMMETRY; {_FORM}"
        )
    _, _, form, kind, symmetry = words
    if kind == "complex":
        raise ImportFormatError(
            f"{path}: complex entries; stiffness and mass are real, so write their real part"
        )
    for word, known in (
        (form, ("coordinate", "array")),
        (kind, ("real", "integer", "double")),
        (symmetry, ("general", "symmetric", "skew-symmetric")),
    ):
        if word not in known:
            raise ImportFormatError(
                f"{path}: not readable as Matrix Market: '{word[:40]}' in the first line is not read, only "
                f"{' or '.join(known)} is; {_FORM}"
            )
    at = next((i for i, line in enumerate(lines) if i and line.strip() and not line.startswith("%")), None)
    if at is None:
        raise ImportFormatError(f"{path}: not readable as Matrix Market: no line states the size; {_FORM}")
    is_sparse = form == "coordinate"
    try:
        sizes = [plain_integer(word) for word in lines[at].split()]
    except ValueError:
        sizes = []
    if len(sizes) != (3 if is_sparse else 2) or min(sizes) < 0:
        wanted = "rows, columns and entries" if is_sparse else "rows and columns"
        raise ImportFormatError(
            f"{path}: line {at + 1}: not readable as Matrix Market: '{lines[at][:60]}' is not the number of "
            f"{wanted}; {_FORM}"
        )
    rows, columns = sizes[:2]
    entries = sizes[2] if is_sparse else _stored(rows, columns, symmetry)
    header = _Header(path, is_sparse, symmetry, at + 1, rows, columns, entries)
    if symmetry != "general" and rows != columns:
        raise header.error(f"a {symmetry} matrix of {rows} rows and {columns} columns")
    if is_sparse and max(rows, columns) > entries + MOST_EMPTY:
        raise header.error(
            f"{rows} rows and {columns} columns for {entries} entries; at most {MOST_EMPTY} rows or columns "
            "more than entries are read"
        )
    return header


def _stored(rows: int, columns: int, symmetry: str) -> int:
    """Number of entries in the array format: all, or those of one triangle."""
    if symmetry == "general":
        return rows * columns
    return rows * (rows + 1 if symmetry == "symmetric" else rows - 1) // 2


def _numbers(header: _Header, below: list[tuple[int, str]], width: int) -> FloatArray:
    """All numbers (entries, width) in the lines below the size; the number of lines is checked first."""
    if len(below) != header.entries:
        raise header.error(
            f"{header.entries} entries are stated, but {len(below)} lines follow; is the file cut short?"
        )
    table = number_table(below, [line.split() for _, line in below], width)
    if isinstance(table, tuple):
        at, text = table
        wanted = "row, column, value" if width == 3 else "one value"
        raise header.error(f"'{text.strip()[:60]}' is not {wanted}", at)
    return table


def _places(header: _Header, below: list[tuple[int, str]], given: FloatArray, n: int) -> IntArray:
    """Row or column indices from 0, for numbers in the file that count from 1."""
    # Written so that NaN counts as outside, too.
    outside = np.flatnonzero(~((given >= 1) & (given <= n) & (given == np.round(given))))
    if outside.size:
        raise header.error(f"{given[outside[0]]:g} is no row or column of {n}", below[outside[0]][0])
    return given.astype(np.int64) - 1


def _places_of_array(header: _Header) -> tuple[IntArray, IntArray]:
    """Rows and columns of the entries of the array format, column after column."""
    if header.symmetry == "general":
        place = np.arange(header.entries)
        rows = max(header.rows, 1)
        return place % rows, place // rows
    column, row = np.triu_indices(header.rows, 0 if header.symmetry == "symmetric" else 1)
    return row, column


def _filled_in(header: _Header, row: IntArray, column: IntArray, values: FloatArray) -> csc_array:
    if header.symmetry != "general":
        beside = row != column
        sign = 1.0 if header.symmetry == "symmetric" else -1.0
        row, column = np.concatenate([row, column[beside]]), np.concatenate([column, row[beside]])
        values = np.concatenate([values, sign * values[beside]])
    matrix = csc_array(coo_array((values, (row, column)), shape=(header.rows, header.columns)))
    if matrix.nnz < len(values):
        raise ImportFormatError(
            f"{header.path}: an entry is given twice; write the matrix again, each entry once"
        )
    if not header.is_sparse:  # dense formats store zeros, which are no entries of a sparse matrix
        matrix.eliminate_zeros()
    return matrix
