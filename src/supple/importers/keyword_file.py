"""Syntax of Abaqus and CalculiX keyword files."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.inclusion import Inclusions, included_file
from supple.importers.plain_number import is_finite_number, is_integer, is_plain


@dataclass(frozen=True)
class KeywordBlock:
    """One keyword, its options, and the data lines below it; `line` is an index of `KeywordFile.lines`.

    Names of options are stored without blanks, which both programs ignore (`REF NODE` is `REFNODE`).

    blank : for each blank data line, the number of data lines above it
    """

    name: str
    options: dict[str, str]
    line: int
    data: tuple[tuple[int, str], ...]
    blank: tuple[int, ...] = ()

    @property
    def placed_data(self) -> list[tuple[int, str]]:
        """The data lines, with the blank lines above them as empty texts; thus every line keeps its place."""
        made, blank = [], Counter(self.blank)
        for i, (line, text) in enumerate(self.data):
            made += [*blank[i] * [(line, "")], (line, text)]
        return made

    @property
    def key(self) -> str:
        """The keyword without blanks, which both programs ignore."""
        return self.name.replace(" ", "")


@dataclass(frozen=True)
class KeywordFile:
    """All lines of a file and of those it includes, cut into blocks."""

    path: Path
    lines: tuple[tuple[Path, int, str], ...]
    blocks: tuple[KeywordBlock, ...]

    def error(self, line: int, message: str) -> ImportFormatError:
        """The error for a mistake found at a line of this file."""
        return ImportFormatError(f"{self.place(line)}: {message}")

    def place(self, line: int) -> str:
        """Path and number of a line."""
        path, number, _ = self.lines[line]
        return f"{path}, line {number}"

    @cached_property
    def numbers(self) -> IntArray:
        """Number of each line in its file."""
        return np.array([number for _, number, _ in self.lines], dtype=np.int64)


@dataclass(frozen=True)
class IntegerRows:
    """Integers of a block's data, the line index of each, and whether it is the first of its line."""

    values: IntArray
    lines: IntArray
    first: BoolArray


def read_keyword_file(path: Path) -> KeywordFile:
    """Blocks of a keyword file: keywords and option names in upper case, comments dropped, files included.

    Raises
    ------
    ImportFormatError   a file missing, or including itself; data before the first keyword
    """
    inclusions = Inclusions("export the model as text (.inp)")
    lines = _expanded(path, inclusions.lines(path), inclusions, path.parent, 0)
    file = KeywordFile(path, tuple(each for each in lines if each[2]), ())
    blocks: list[KeywordBlock] = []
    header, line, data, blank = "", 0, [], []
    i = -1
    for _, _, text in lines:
        if not text:
            blank.append(len(data))
            continue
        i += 1
        if text.startswith("*"):
            if header:
                blocks.append(_block(header, line, data, blank))
            header, line, data, blank = text, i, [], []
        elif not header and text[0] not in "+-.0123456789":
            continue  # a title
        elif not header:
            raise file.error(i, "data before the first *KEYWORD; is this an Abaqus or CalculiX file?")
        elif header.endswith(",") and not data:  # a keyword may run over several lines
            header += text
        else:
            data.append((i, text))
    if header:
        blocks.append(_block(header, line, data, blank))
    return KeywordFile(path, file.lines, tuple(blocks))


def fields(text: str) -> list[str]:
    """Comma-separated fields of a data line, without the empty fields at its end."""
    return [field.strip() for field in text.rstrip(", \t").split(",")]


def integers(file: KeywordFile, block: KeywordBlock) -> IntegerRows:
    """All fields of a block's data as integers; ImportFormatError names the line of any other field."""
    rows = [fields(text) for _, text in block.data]
    counts = np.array([len(row) for row in rows], dtype=np.int64)
    lines = np.repeat(np.array([i for i, _ in block.data], dtype=np.int64), counts)
    first = np.zeros(counts.sum(), dtype=bool)
    first[np.cumsum(counts) - counts] = True
    words = [word for row in rows for word in row]
    return IntegerRows(_converted(file, words, lines, np.int64), lines, first)


def numbered_points(file: KeywordFile, block: KeywordBlock) -> tuple[IntArray, FloatArray, IntArray]:
    """Ids (N,), positions (N, 3) and line indices (N,) of data lines `id, x, y, z`.

    Raises ImportFormatError, with its place, for any other line.
    """
    rows = [fields(text) for _, text in block.data]
    lines = np.array([i for i, _ in block.data], dtype=np.int64)
    for i, row in zip(lines, rows, strict=True):
        # Missing coordinates are 0, and a normal may follow; the last line of the file may be cut.
        if len(row) > 7 or (len(row) < 4 and i == len(file.lines) - 1):
            raise file.error(i, f"{len(row)} fields; a node is id, x, y, z (is the file cut short?)")
        row[:] = [*(word or "0" for word in row), "0", "0", "0"][:4]
    ids = _converted(file, [row[0] for row in rows], lines, np.int64)
    words = [word.upper().replace("D", "E") for row in rows for word in row[1:]]  # Fortran writes 1.D0
    positions = _converted(file, words, np.repeat(lines, 3), np.float64)
    return ids, positions.reshape(-1, 3), lines


def numbers(file: KeywordFile, line: int, words: list[str]) -> list[float]:
    """Words of a data line as numbers; an empty word counts as 0."""
    plain = [(word or "0").upper().replace("D", "E") for word in words]
    return _converted(file, plain, np.full(len(plain), line), np.float64).tolist()


def number_rows(file: KeywordFile, block: KeywordBlock) -> list[list[float]]:
    """The numbers of each data line of a block."""
    return [numbers(file, line, fields(text)) for line, text in block.data]


def _converted(file: KeywordFile, words: list[str], lines: IntArray, dtype: type) -> NDArray:
    try:
        values = np.array(words, dtype=dtype)
    except (ValueError, OverflowError):
        values = None
    if values is None or not is_plain("".join(words)) or not np.isfinite(values).all():
        whole = dtype is np.int64
        is_valid = is_integer if whole else is_finite_number
        word, line = next(pair for pair in zip(words, lines, strict=True) if not is_valid(pair[0]))
        what = "a whole number of 64 bits" if whole else "a number"
        raise file.error(line, f"'{word[:40]}' is not {what}; correct it, or remove the line")
    return values


def _expanded(
    path: Path, lines: list[str], inclusions: Inclusions, main: Path, depth: int
) -> list[tuple[Path, int, str]]:
    """Lines of a file without comments, with included files inserted; blank data lines have no text.

    main : folder of the main file. Both programs search included files in this folder; here the folder of the
        including file is searched first
    """
    found = []
    for number, line in enumerate(lines, start=1):
        text = line.strip()
        if text.startswith("**") or ("*" in text and not text.strip("* ,")):
            continue
        if not text.strip(" ,"):
            text = ""
        if text.upper().startswith("*INCLUDE"):
            target = included_file(text.partition("=")[2].strip().strip('"'), path.parent, main)
            below = inclusions.included(path, number, target, depth + 1)
            found += _expanded(target, below, inclusions, main, depth + 1)
        else:
            found.append((path, number, text))
    return found


def _block(header: str, line: int, data: list[tuple[int, str]], blank: list[int]) -> KeywordBlock:
    name, *options = header.split(",")
    pairs = [option.partition("=") for option in options if option.strip()]
    return KeywordBlock(
        " ".join(name[1:].upper().split()),
        {"".join(key.upper().split()): value.strip().strip('"') for key, _, value in pairs},
        line,
        tuple(data),
        tuple(blank),
    )
