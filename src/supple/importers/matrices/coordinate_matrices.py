"""Matrices as lists of entries: Abaqus (*MATRIX GENERATE, .mtx) and CalculiX (MATRIXSTORAGE, .sti, .mas)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.matrices.labelled_matrix import (
    LabelledMatrix,
    from_entries,
    from_labelled_entries,
    number_table,
    printed_resolution,
)
from supple.importers.node_table import NodeTable
from supple.importers.plain_number import is_plain_digits
from supple.importers.text_file import file_lines

_LARGEST_WHOLE = 2.0**53
"""Largest node id or row number that a float represents exactly; larger ones are rejected."""


def read_abaqus_matrix(path: str | Path, nodes: NodeTable | None = None) -> LabelledMatrix:
    """Matrix of Abaqus (*MATRIX OUTPUT): FORMAT=MATRIX INPUT, or COORDINATE.

    Lines of MATRIX INPUT are node, component, node, component, value. Lines of COORDINATE are row, column,
    value, with rows counted from 1 in the order of node ids and components. One triangle is sufficient.

    Parameters
    ----------
    nodes : of the model; their number determines the freedoms per node in COORDINATE, 3 or 6
    Raises
    ------
    ImportFormatError   missing or cut file; lines of another form; an entry given twice; not symmetric; a
                        number of rows that does not fit the nodes
    """
    path = Path(path)
    if len(_words(_lines(path)[0][1], None)) == 3:
        return _by_coordinates(path, np.empty(0, int) if nodes is None else np.sort(nodes.ids))
    table, resolution = _table(path, 5, "node, component, node, component, value", ",")
    labels = _whole(path, table[:, :4], "a node id or component")
    return from_labelled_entries(str(path), labels[:, :2], labels[:, 2:], table[:, 4], resolution)


def _by_coordinates(path: Path, ids: IntArray) -> LabelledMatrix:
    table, resolution = _table(path, 3, "row, column, value", None)
    numbers = _whole(path, table[:, :2], "a row or column number")
    n = int(numbers.max())
    per_node = next((k for k in (3, 6) if n == k * len(ids)), None)
    if per_node is None or numbers.min() < 1:
        raise ImportFormatError(
            f"{path}: rows {numbers.min()} to {n}, which are neither 3 nor 6 freedoms of each of {len(ids)} "
            "nodes; take the mesh file of the same model, without unused nodes, or write the matrix "
            "with FORMAT=MATRIX INPUT"
        )
    freedoms = np.column_stack([np.repeat(ids, per_node), np.tile(np.arange(1, per_node + 1), len(ids))])
    matrix = from_entries(str(path), numbers[:, 0] - 1, numbers[:, 1] - 1, table[:, 2], freedoms)
    return LabelledMatrix(str(path), matrix, freedoms, resolution)


def read_calculix_matrix(path: str | Path, freedoms: str | Path | None = None) -> LabelledMatrix:
    """Matrix that CalculiX writes by *FREQUENCY, SOLVER=MATRIXSTORAGE: row, column, value, counted from 1.

    Parameters
    ----------
    freedoms : the .dof file with `node.component` of each row; None: the .dof file of the same name
    Raises
    ------
    ImportFormatError   missing or cut files; lines of another form; rows that the .dof file does not name;
                        fewer rows than it names; an entry given twice
    """
    path = Path(path)
    map_path = path.with_suffix(".dof") if freedoms is None else Path(freedoms)
    rows_of_map = _map(map_path)
    table, resolution = _table(path, 3, "row, column, value", None)
    numbers = _whole(path, table[:, :2], "a row or column number")
    n = len(rows_of_map)
    outside = np.flatnonzero(((numbers < 1) | (numbers > n)).any(axis=1))
    if outside.size:
        raise ImportFormatError(
            f"{path}: an entry of row {numbers[outside[0], 0]} and column {numbers[outside[0], 1]}, but "
            f"{map_path} names {n} freedoms; take both files from the same run"
        )
    if numbers.max() < n:
        raise ImportFormatError(
            f"{path}: {numbers.max()} rows, but {map_path} names {n} freedoms; is the file cut short? Take "
            "both files from the same run"
        )
    matrix = from_entries(str(path), numbers[:, 0] - 1, numbers[:, 1] - 1, table[:, 2], rows_of_map)
    return LabelledMatrix(str(path), matrix, rows_of_map, resolution)


def _map(path: Path) -> IntArray:
    words = [(number, text.strip()) for number, text in _lines(path)]
    found = []
    for number, word in words:
        node, dot, component = word.partition(".")
        if not (dot and is_plain_digits(node) and is_plain_digits(component)):
            raise ImportFormatError(
                f"{path}, line {number}: '{word[:40]}' is not NODE.COMPONENT; write it again"
            )
        found.append((int(node), int(component)))
    return np.array(found, dtype=np.int64)


def _table(path: Path, width: int, form: str, delimiter: str | None) -> tuple[FloatArray, float]:
    """Numbers (k, width) of all lines but comments, and the resolution of the last column."""
    lines = _lines(path)
    rows = [_words(text, delimiter) for _, text in lines]
    table = number_table(lines, rows, width)
    if isinstance(table, tuple):
        number, text = table
        raise ImportFormatError(
            f"{path}, line {number}: '{text.strip()[:60]}' is not {form}; is the file cut short, or of "
            "another format?"
        )
    return table, min(printed_resolution(row[-1]) for row in rows[:1000])


def _words(text: str, delimiter: str | None) -> list[str]:
    """Words separated by a delimiter; None: by commas and blanks."""
    return text.replace(",", " ").split() if delimiter is None else [w.strip() for w in text.split(delimiter)]


def _whole(path: Path, values: FloatArray, what: str) -> IntArray:
    whole = np.where(np.isfinite(values), values, -0.5)
    wrong = (whole != np.round(whole)) | (np.abs(whole) > _LARGEST_WHOLE)
    if wrong.any():
        raise ImportFormatError(f"{path}: {values[wrong][0]:g} is not {what}; write the file again")
    return whole.astype(np.int64)


def _lines(path: Path) -> list[tuple[int, str]]:
    """Lines with their numbers, without comments, keywords (*) and blank lines."""
    found = [
        (number, text)
        for number, text in enumerate(file_lines(path, "write the matrices as text"), start=1)
        if text.strip() and not text.lstrip().startswith("*")
    ]
    if not found:
        raise ImportFormatError(f"{path}: an empty file; write it again")
    return found
