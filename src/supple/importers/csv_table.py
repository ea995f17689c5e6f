"""CSV tables: named columns of numbers and words, checked for missing and unknown columns and for numbers."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources.abc import Traversable
from pathlib import Path

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ImportFormatError
from supple.importers.plain_number import is_plain
from supple.importers.text_file import file_lines, is_file


@dataclass(frozen=True)
class CsvTable:
    """Columns of a comma-separated file with one line of headings; words as written."""

    path: Path | Traversable
    columns: dict[str, tuple[str, ...]]
    lines: tuple[int, ...]
    """Line of each row in the file."""

    def __contains__(self, column: str) -> bool:
        return column in self.columns

    def numbers(self, column: str) -> FloatArray:
        """A column of numbers; ImportFormatError with the line of an entry that is not a number."""
        values = np.empty(len(self.lines))
        for row, word in enumerate(self.columns[column]):
            try:
                if not is_plain(word):
                    raise ValueError(word)
                values[row] = float(word)
            except ValueError as error:
                raise ImportFormatError(
                    f"{self.path}, line {self.lines[row]}: {column} is '{word[:40]}'; write a number"
                ) from error
        return values


def read_csv_table(
    path: str | Path | Traversable, *, required: Iterable[str], optional: Iterable[str] = ()
) -> CsvTable:
    """Table of a CSV file; lines that are empty or start with '#' are ignored.

    required, optional : names of columns; any other name is an error, as it may be misspelt

    Raises
    ------
    ImportFormatError   missing file, missing, unknown or repeated columns, rows of another length
    """
    path = Path(path) if isinstance(path, str) else path
    text = file_lines(path, "export the table as CSV")
    kept = [
        (number, line) for number, line in enumerate(text, 1) if line.strip() and not line.startswith("#")
    ]
    if not kept:
        raise ImportFormatError(f"{path}: empty; the first line holds the names of the columns")
    rows = [_words(path, number, line) for number, line in kept]
    headings, required = rows[0], tuple(required)
    known = (*required, *optional)
    missing = [name for name in required if name not in headings]
    if missing:
        raise ImportFormatError(
            f"{path}: no column {', '.join(missing)}; its columns are {', '.join(headings)}"
        )
    for place, name in enumerate(headings):
        if name not in known or name in headings[:place]:
            what = "a second column" if name in known else "unknown column"
            raise ImportFormatError(
                f"{path}: {what} '{name}'; known columns are {', '.join(known)}; give each of them once"
            )
    for (number, _), row in zip(kept, rows, strict=True):
        if len(row) != len(headings):
            raise ImportFormatError(f"{path}, line {number}: {len(row)} values for {len(headings)} columns")
    body = list(zip(*rows[1:], strict=True)) or [()] * len(headings)
    return CsvTable(path, dict(zip(headings, body, strict=True)), tuple(number for number, _ in kept[1:]))


def named_csv_file(
    folder: Path | Traversable, name: str, table: CsvTable, row: int, what: str
) -> Path | Traversable:
    """The file `name.csv` of a folder, which a row of a table names; ImportFormatError without it.

    what : kind of the file for messages
    """
    file = folder / f"{name}.csv"
    if "/" not in name and is_file(file):
        return file
    where = f"{table.path}, line {table.lines[row]}: unknown {what} '{name}'"
    try:
        there = sorted(entry.name[:-4] for entry in folder.iterdir() if entry.name.endswith(".csv"))
    except (OSError, ValueError) as error:
        raise ImportFormatError(f"{where}; there is no folder {folder}: correct its name") from error
    raise ImportFormatError(f"{where}; {folder} has {', '.join(there) or 'no .csv files'}")


def _words(path: Path | Traversable, number: int, line: str) -> tuple[str, ...]:
    """The words of a line; a quoted word ends on the same line."""
    try:
        (row,) = csv.reader([line], strict=True)
    except csv.Error as error:
        raise ImportFormatError(
            f"{path}, line {number}: not a row of a CSV table ({error}); correct its quotes"
        ) from error
    return tuple(word.strip() for word in row)
