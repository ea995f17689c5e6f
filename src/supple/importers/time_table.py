"""Tables of one quantity over time, rows of two numbers in a CSV file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ImportFormatError
from supple.importers.plain_number import is_number, is_plain
from supple.importers.text_file import file_lines


def read_time_table(path: Path) -> tuple[FloatArray, FloatArray]:
    """Times (k,) and values (k,) of a CSV file with rows `time,value`; # begins a comment.

    The first row may be a heading of words.

    Raises
    ------
    ImportFormatError   a file other than two columns of finite numbers with increasing times
    """
    rows = _rows(path)
    if rows.shape[0] < 2 or rows.shape[1] != 2:
        raise ImportFormatError(
            f"{path} has {rows.shape[0]} rows of {rows.shape[1]} numbers; write two or more rows time,value"
        )
    if not np.isfinite(rows).all():
        raise ImportFormatError(f"{path} has NaN or infinite numbers; remove these rows")
    backwards = np.flatnonzero(np.diff(rows[:, 0]) <= 0)
    if backwards.size:
        row = int(backwards[0]) + 1
        raise ImportFormatError(
            f"{path}: times must increase, but row {row + 1} has {rows[row, 0]:g} after {rows[row - 1, 0]:g}"
        )
    return rows[:, 0], rows[:, 1]


def _rows(path: Path) -> FloatArray:
    """All rows (k, m) of numbers; m is 0 for an empty file."""
    rows: list[list[float]] = []
    is_first = True
    for number, line in enumerate(file_lines(path, "export the table as CSV"), start=1):
        text = line.partition("#")[0]
        if not text.strip():
            continue
        was_first, is_first = is_first, False
        if was_first and all(_is_word(each) for each in text.split(",")):
            continue
        try:
            if not is_plain(text):
                raise ValueError(text)
            rows.append([float(word) for word in text.split(",")])
        except ValueError as error:
            raise ImportFormatError(
                f"{path}, line {number}: '{text.strip()[:40]}'; write rows of two numbers, time,value"
            ) from error
        if len(rows[-1]) != len(rows[0]):
            raise ImportFormatError(
                f"{path}, line {number}: {len(rows[-1])} numbers, and {len(rows[0])} above; write rows of "
                "two numbers, time,value"
            )
    return np.array(rows, dtype=np.float64).reshape(len(rows), -1 if rows else 0)


def _is_word(text: str) -> bool:
    """Whether an entry begins with a letter and is no number, such as nan."""
    return not is_number(text) and text.strip(" \t\"'")[:1].isalpha()
