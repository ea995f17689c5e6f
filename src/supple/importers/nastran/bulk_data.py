"""Nastran bulk data: the grammar of cards (small, large and free fields), before any meaning."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from supple.errors import ImportFormatError
from supple.importers.inclusion import Inclusions
from supple.importers.plain_number import is_plain, plain_integer

_CARD_NAME = re.compile(r"[A-Z][A-Z0-9]{0,7}$")
_EXPONENT_WITHOUT_E = re.compile(r"([+-]?[0-9]*\.?[0-9]*)([+-][0-9]+)$")
_BEGIN = re.compile(r"\s*BEGIN[\s,]+(BULK|SUPER)\b(.*)", re.IGNORECASE)
_INCLUDE = re.compile(r"\s*INCLUDE\s+(.*)", re.IGNORECASE)
_PARAM_ABOVE = re.compile(r"\s*PARAM\s*,", re.IGNORECASE)

RawLine = tuple[Path, int, str]


@dataclass(frozen=True)
class BulkCard:
    """A card with its data fields as written: `fields[0]` is Nastran's field 2, eight to a row.

    A blank field is an empty string; fields beyond the last written one count as blank.
    """

    name: str
    fields: tuple[str, ...]
    path: Path
    line: int

    def error(self, message: str) -> ImportFormatError:
        """The error for a mistake on this card: file, line, card, what is wrong."""
        return ImportFormatError(f"{self.path}, line {self.line}: {self.name}: {message}")

    def word(self, place: int) -> str:
        """Field as written, in upper case; empty where blank."""
        return self.fields[place].upper() if place < len(self.fields) else ""

    def integer(self, place: int, what: str, default: int | None = None) -> int:
        """Field as a whole number; `default` where it is blank, which is a mistake without one."""
        word = self.word(place)
        if not word:
            if default is None:
                raise self.error(f"{what} (field {self._field(place)}) is blank; give a whole number")
            return default
        try:
            return plain_integer(word)
        except ValueError:
            raise self.error(
                f"{what} (field {self._field(place)}) is '{word[:40]}', not a whole number of 64 bits; "
                "correct it"
            ) from None

    def real(self, place: int, what: str, default: float | None = None) -> float:
        """Field as a number; `default` where it is blank, which is a mistake without one."""
        word = self.word(place)
        if not word:
            if default is None:
                raise self.error(f"{what} (field {self._field(place)}) is blank; give a number")
            return default
        try:
            return bulk_real(word)
        except ValueError:
            raise self.error(
                f"{what} (field {self._field(place)}) is '{word[:40]}', not a number; correct it"
            ) from None

    def _field(self, place: int) -> int:
        """Nastran's number of the field on its own row: 2 to 9."""
        return place % 8 + 2


@dataclass(frozen=True)
class BulkFile:
    """All cards of a file and of those it includes, in their order."""

    path: Path
    cards: tuple[BulkCard, ...]

    @cached_property
    def by_name(self) -> dict[str, list[BulkCard]]:
        """Cards of each name."""
        found: dict[str, list[BulkCard]] = {}
        for card in self.cards:
            found.setdefault(card.name, []).append(card)
        return found

    def named(self, *names: str) -> list[BulkCard]:
        """All cards of these names, those of the first name first."""
        return [card for name in names for card in self.by_name.get(name, [])]


def bulk_real(word: str) -> float:
    """A number as Nastran writes it: 1.5, 1.5E3, 1.5D3 or 1.5+3; ValueError for anything else."""
    if not is_plain(word):
        raise ValueError(word)
    try:
        value = float(word)
    except ValueError:
        match = _EXPONENT_WITHOUT_E.match(word)
        value = float(f"{match[1]}E{match[2]}" if match else word.upper().replace("D", "E"))
    if value - value != 0:  # nan and inf are words that float() knows and Nastran does not
        raise ValueError(word)
    return value


def read_bulk_data(path: str | Path) -> BulkFile:
    """Cards of a Nastran file: from BEGIN BULK to ENDDATA, or the whole file where it has neither.

    A PARAM may stand above BEGIN BULK, too, among the cards of case control.

    Small fields (8 columns), large fields (16, NAME*), free fields (commas), tabs, comments and INCLUDE are
    understood. A continuation stands right below the line it continues.

    Raises
    ------
    ImportFormatError   missing, cut or binary file, or one that includes itself; what is no card;
                        continuations out of order
    """
    path = Path(path)
    cards: list[BulkCard] = []
    name, fields, start, mnemonic = "", [], (path, 0), ""
    for file, number, text in _bulk_lines(path):
        first, data, last = _split(file, number, text)
        continues = not first or first[0] in "+*"
        if continues:
            if not name:
                raise _error(file, number, "a continuation without a card above it; is a line missing?")
            label = first.strip("+* ")
            if label and mnemonic and label != mnemonic:
                raise _error(
                    file,
                    number,
                    f"{name}: continues '{label}', but the line above announces '{mnemonic}'; write "
                    "continuations in order, right below their card",
                )
            if len(data) == 8 and len(fields) % 8:
                raise _error(
                    file,
                    number,
                    f"{name}: small fields continue a single large line; write a row as two large lines",
                )
            fields += data
        else:
            if name:
                cards.append(BulkCard(name, tuple(fields), *start))
            name, fields, start = _card_name(file, number, first), data, (file, number)
        mnemonic = last.strip("+* ") if last[:1] in ("+", "*") else ""
    if name:
        cards.append(BulkCard(name, tuple(fields), *start))
    return BulkFile(path, tuple(cards))


def _card_name(file: Path, number: int, first: str) -> str:
    name = first.rstrip("* ").upper()
    if not _CARD_NAME.match(name):
        raise _error(
            file, number, f"'{first[:20]}' is not the name of a card; is this a Nastran bulk data file?"
        )
    return name


def _split(file: Path, number: int, text: str) -> tuple[str, list[str], str]:
    """First field, data fields (8, or 4 large ones) and continuation label of a line."""
    if "," in text[:10] or (text[0] in "+*," and "," in text):
        words = [word.strip() for word in text.split(",")]
        if len(words) > 10:
            raise _error(
                file, number, f"{len(words)} fields; a line has at most 10: continue it on the next line"
            )
        width = 4 if "*" in words[0] else 8
        if width == 4 and len(words) > 6:
            raise _error(file, number, f"{len(words)} large fields; a line has a name, 4 fields and a label")
        data = words[1 : width + 1]
        last = words[width + 1] if len(words) > width + 1 else ""
        if last and last[0] not in "+*":
            raise _error(
                file,
                number,
                f"'{last}' stands where only a continuation label may; write it on the next line",
            )
        return words[0], data + [""] * (width - len(data)), last
    first = text[:8].strip()
    width, count = (16, 4) if "*" in first else (8, 8)
    return (
        first,
        [text[8 + width * i : 8 + width * (i + 1)].strip() for i in range(count)],
        text[72:80].strip(),
    )


def _bulk_lines(path: Path) -> Iterator[RawLine]:
    """Lines of the bulk data section that mean something."""
    inclusions = Inclusions("export the model as text (.bdf)")
    lines = _meaning(path, inclusions.lines(path), inclusions, 0)
    starts = [i for i, (_, _, text) in enumerate(lines) if _BEGIN.match(text)]
    if len(starts) > 1 or any("SUPER" in lines[i][2].upper() for i in starts):
        file, number, _ = lines[starts[-1]]
        raise _error(file, number, "parts (BEGIN SUPER) are not read; export each as a file of its own")
    first = starts[0] + 1 if starts else 0
    yield from (line for line in lines[:first] if _PARAM_ABOVE.match(line[2]))
    for file, number, text in lines[first:]:
        if text.strip().upper() == "ENDDATA":
            return
        yield file, number, text
    if starts:
        file, number, _ = lines[starts[0]]
        raise _error(file, number, "BEGIN BULK, but no ENDDATA follows; is the file cut short?")


def _meaning(path: Path, read: list[str], inclusions: Inclusions, depth: int) -> list[RawLine]:
    """Lines without comments and blank ones, with those of included files in place."""
    found: list[RawLine] = []
    lines = enumerate(read, start=1)
    for number, line in lines:
        text = line.partition("$")[0].rstrip()
        if not text:
            continue
        text = text.expandtabs(8)
        included = _INCLUDE.match(text)
        if not included:
            found.append((path, number, text))
            continue
        name = included[1].strip()
        while name[0] in "'\"" and name.count(name[0]) == 1:  # a name in quotes may run over several lines
            _, more = next(lines, (0, name[0]))
            name += more.strip()
        target = path.parent / name.strip("'\"").replace("\\", "/")
        below = inclusions.included(path, number, target, depth + 1)
        found += _meaning(target, below, inclusions, depth + 1)
    return found


def _error(path: Path, number: int, message: str) -> ImportFormatError:
    return ImportFormatError(f"{path}, line {number}: {message}")
