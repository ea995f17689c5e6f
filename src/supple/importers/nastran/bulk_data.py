"""Syntax of Nastran bulk data: cards in small, large and free fields."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.inclusion import Inclusions, included_file
from supple.importers.nastran.without_effect import has_no_effect
from supple.importers.plain_number import is_plain, plain_integer
from supple.importers.text_file import is_file

Number = TypeVar("Number", int, float)

_CARD_NAME = re.compile(r"[A-Z][A-Z0-9]{0,7}$")
_EXPONENT_WITHOUT_E = re.compile(r"([+-]?[0-9]*\.?[0-9]*)([+-][0-9]+)$")
_CEND = re.compile(r"\s*CEND\b", re.IGNORECASE)
_BEGIN = re.compile(r"\s*BEGIN\b", re.IGNORECASE)
_PART = re.compile(r"\b([A-Z]+)\s*=\s*(\w+)", re.IGNORECASE)
_INCLUDE = re.compile(r"\s*INCLUDE\b\s*(.*)", re.IGNORECASE)
_PARAM_ABOVE = re.compile(r"\s*PARAM\s*,", re.IGNORECASE)
_END = re.compile(r"\s*ENDDATA", re.IGNORECASE)
_REPEATS = re.compile(r"=\s*\(?\s*([0-9]+)\s*\)?$")
_GROWS = re.compile(r"\*\s*\(?\s*([^()]+?)\s*\)?$")

MOST_REPETITIONS = 10**6
"""Largest number n of a replication `=n`; a larger n is an ImportFormatError."""


class RawLine(NamedTuple):
    """A line of a file."""

    path: Path
    number: int
    text: str

    def error(self, message: str) -> ImportFormatError:
        """ImportFormatError with path and number of this line, then `message`."""
        return ImportFormatError(f"{self.path}, line {self.number}: {message}")


# Start of a line in place of a missing included file.
_MISSING = "INCLUDE "


class BulkCard(NamedTuple):
    """A card with its data fields as written: `fields[0]` is Nastran's field 2; a row has eight data fields.

    A blank field is an empty string; fields beyond the last written one count as blank. In the methods,
    `place` is an index in `fields`, and `what` is the name of the field for messages.
    """

    name: str
    fields: tuple[str, ...]
    path: Path
    line: int

    def error(self, message: str) -> ImportFormatError:
        """ImportFormatError whose message has file, line and name of this card, then `message`."""
        return ImportFormatError(f"{self.path}, line {self.line}: {self.name}: {message}")

    def word(self, place: int) -> str:
        """The field in upper case; an empty string if it is blank."""
        return self.fields[place].upper() if place < len(self.fields) else ""

    def integer(self, place: int, what: str, default: int | None = None) -> int:
        """The field as an integer of 64 bits; `default` if it is blank.

        ImportFormatError for another word, or if the field is blank without a default.
        """
        return self._value(place, what, default, plain_integer, "a whole number", " of 64 bits")

    def real(self, place: int, what: str, default: float | None = None) -> float:
        """The field as a number; `default` and errors as for `integer`."""
        return self._value(place, what, default, bulk_real, "a number")

    def reals(self, first: int, *whats: str) -> list[float]:
        """The fields from index `first` on as numbers, 0 if blank."""
        return [self.real(first + i, what, 0.0) for i, what in enumerate(whats)]

    def property_id(self) -> int:
        """The id of the property of an element, which is that of the element if its field is blank."""
        return self.integer(1, "the property id", self.integer(0, "the element id"))

    def _value(
        self,
        place: int,
        what: str,
        default: Number | None,
        read: Callable[[str], Number],
        kind: str,
        limit: str = "",
    ) -> Number:
        word = self.word(place)
        what = f"{what} (field {place % 8 + 2})"  # Nastran's number in its row, 2 to 9
        if not word:
            if default is None:
                raise self.error(f"{what} is blank; give {kind}")
            return default
        try:
            return read(word)
        except ValueError:
            raise self.error(f"{what} is '{word[:40]}', not {kind}{limit}; correct it") from None

    def ranges(self, places: Iterable[int], what: str = "an id") -> list[range]:
        """Ids in a list of fields without the blank ones: one each, or A THRU B, or A THRU B BY STEP.

        ImportFormatError if an id is not an integer.
        """
        found: list[range] = []
        words = ((place, self.word(place)) for place in places if self.word(place))
        for place, word in words:
            if word in ("THRU", "BY") and found:
                number, first = self.integer(next(words, (place, ""))[0], what), found.pop()
                ends = (
                    (first.start, number + 1) if word == "THRU" else (first.start, first.stop, max(number, 1))
                )
                found.append(range(*ends))
            else:
                number = self.integer(place, what)
                found.append(range(number, number + 1))
        return found

    def is_blank(self, start: int, stop: int) -> bool:
        """Whether the fields from `start` to before `stop` are all blank."""
        return not any(self.fields[start:stop])

    def same_as(self, other: BulkCard) -> bool:
        """Whether another card has equal name and fields: 1. and 1.0 are equal, trailing blanks ignored."""
        return self.name == other.name and _content(self.fields) == _content(other.fields)


@dataclass(frozen=True)
class BulkFile:
    """Cards of a file and of the files that it includes, in order.

    above : lines of executive and case control, above the cards
    cards : those of the main bulk data
    parts : {(kind, name): its cards}; BEGIN SUPER = 1 starts the part ("SUPER", "1")
    ended : whether the file has ENDDATA, which Nastran requires
    """

    path: Path
    cards: tuple[BulkCard, ...]
    above: tuple[str, ...] = ()
    parts: dict[tuple[str, str], BulkFile] = field(default_factory=dict)
    ended: bool = True

    @cached_property
    def by_name(self) -> dict[str, list[BulkCard]]:
        """Cards by name, in the order of the file."""
        found: dict[str, list[BulkCard]] = {}
        for card in self.cards:
            found.setdefault(card.name, []).append(card)
        return found

    def named(self, *names: str) -> list[BulkCard]:
        """All cards of these names, those of the first name first."""
        return [card for name in names for card in self.by_name.get(name, [])]


def _content(fields: tuple[str, ...]) -> list[str | float]:
    values: list[str | float] = []
    for word in fields:
        try:
            values.append(bulk_real(word))
        except ValueError:
            values.append(word.upper())
    while values and values[-1] == "":
        values.pop()
    return values


def integer_column(cards: Sequence[BulkCard], place: int, what: str, default: int | None = None) -> IntArray:
    """One field of many cards as integers, as `BulkCard.integer` reads it."""
    words = _column(cards, place)
    if is_plain("".join(words)):
        try:
            return np.array([int(w) if w else default for w in words], dtype=np.int64)
        except (ValueError, TypeError, OverflowError):
            pass
    return np.array([card.integer(place, what, default) for card in cards], dtype=np.int64)


def real_column(cards: Sequence[BulkCard], place: int, what: str, default: float | None = None) -> FloatArray:
    """One field of many cards as numbers, as `BulkCard.real` reads it."""
    words = _column(cards, place)
    try:
        if default is None and not all(words):
            raise ValueError
        return np.array([_quick_real(w) if w else default for w in words], dtype=np.float64)
    except ValueError:
        return np.array([card.real(place, what, default) for card in cards], dtype=np.float64)


def _column(cards: Sequence[BulkCard], place: int) -> list[str]:
    return [card.fields[place] if place < len(card.fields) else "" for card in cards]


def by_id(cards: Sequence[BulkCard], what: str) -> dict[int, BulkCard]:
    """Cards by the id in their first field; ImportFormatError if cards with the same id differ."""
    found: dict[int, BulkCard] = {}
    for card in cards:
        number = card.integer(0, f"the {what} id")
        first = found.setdefault(number, card)
        if first is not card and not card.same_as(first):
            raise card.error(
                f"{what} {number} is defined a second time and differs from that of line {first.line}; "
                "renumber or remove it"
            )
    return found


def bulk_real(word: str) -> float:
    """A number as Nastran writes it: 1.5, 1.5E3, 1.5D3 or 1.5+3; ValueError for anything else."""
    if not is_plain(word):
        raise ValueError(word)
    return _quick_real(word)


def _quick_real(word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        match = _EXPONENT_WITHOUT_E.match(word)
        value = float(f"{match[1]}E{match[2]}" if match else word.upper().replace("D", "E"))
    if value - value != 0 or "_" in word:  # nan, inf and 1_0 are numbers for float(), not for Nastran
        raise ValueError(word)
    return value


def read_bulk_data(path: str | Path, absent: list[BulkCard] | None = None) -> BulkFile:
    """Cards of a Nastran file from BEGIN BULK to ENDDATA; without BEGIN BULK, from the first line.

    A PARAM with commas may also stand above BEGIN BULK, in case control. Lines after ENDDATA are not read.

    Small fields (8 columns), large fields (16, NAME*), free fields (commas), tabs, comments, INCLUDE and
    replication (=, ==, *(x), =n) are supported. A continuation directly follows the line that it continues;
    with the label of this line, it may stand anywhere.

    absent : list to which INCLUDE lines of missing files are added, with the second field CASE if they
             belong to case control; if None, missing files are errors, except those of case control.
             Missing files of executive control, above CEND, are ignored

    Raises
    ------
    ImportFormatError   missing or binary file, or one that includes itself; lines that are not cards;
                        continuations and replications without a card
    """
    path = Path(path)
    above, sections, ended = _sections(path, absent)
    main = [line for line in above if _PARAM_ABOVE.match(line[2])]
    of_parts: dict[tuple[str, str], list[RawLine]] = {}
    for kind, name, lines in sections:
        into = of_parts.setdefault((kind, name), []) if kind else main
        into += lines
    parts = {name: BulkFile(path, tuple(_cards(lines))) for name, lines in of_parts.items()}
    return BulkFile(path, tuple(_cards(main)), tuple(text for _, _, text in above), parts, ended)


@dataclass(eq=False)
class _Piece:
    """A card, or rows with a `label` that continue another piece; `announces` : label of the next row."""

    name: str
    fields: list[str]
    at: RawLine
    label: str
    announces: str


def _cards(lines: Sequence[RawLine]) -> list[BulkCard]:
    pieces: list[_Piece] = []
    orphans: dict[str, _Piece] = {}
    piece: _Piece | None = None
    skipping = False
    rows = [(line, *_split(line)) for line in lines]
    announced = {last[1:].strip().upper() for *_, last in rows if last}
    for line, first, data, last in rows:
        if first.upper() in ("SKIPON", "SKIPOFF"):
            skipping = first.upper() == "SKIPON"
            continue
        if skipping or first.startswith("/"):  # '/' deletes cards of an earlier run
            continue
        announces = last[1:].strip().upper()
        starts = first and first[0] not in "+*"
        if first[:1].isdigit() and piece is not None and has_no_effect(piece.name):
            continue  # a list that continues without a continuation mark
        if (
            last
            and last[0] not in "+*"
            and not has_no_effect(first.upper() if starts else piece.name if piece else "")
        ):
            raise line.error(f"'{last}' is in the field of the continuation label; write it on the next line")
        if starts:
            piece = _Piece(_card_name(line, first), data, line, "", announces)
            pieces.append(piece)
            continue
        label = first[1:].strip().upper()
        if piece is None or (label and label != piece.announces and (piece.announces or label in announced)):
            if not label:
                raise line.error("a continuation without a card above it; is a line missing?")
            if label in orphans and not has_no_effect(piece.name if piece else ""):
                message = f"a second continuation has the label '+{label}'; give each one a different label"
                raise line.error(message)
            above = piece.name if piece and has_no_effect(piece.name) else ""
            piece = orphans[label] = _Piece(above, data, line, label, announces)
            continue
        _append(piece, line, data)
        piece.announces = announces
    _join(pieces, orphans)
    return _replicated(pieces)


def _join(pieces: list[_Piece], orphans: dict[str, _Piece]) -> None:
    """Attach continuation rows to their cards."""
    for piece in pieces:
        while piece.announces and (more := orphans.pop(piece.announces, None)):
            _append(piece, more.at, more.fields)
            piece.announces = more.announces
    for left in orphans.values():
        if not has_no_effect(left.name):
            raise left.at.error(
                f"continues '+{left.label}', which no card announces; is a line missing, or its label "
                "misspelt?"
            )


def _append(piece: _Piece, line: RawLine, data: list[str]) -> None:
    if len(data) == 8 and len(piece.fields) % 8:
        raise line.error(
            f"{piece.name}: small fields continue a single large line; write a row as two large lines"
        )
    piece.fields += data


def _replicated(pieces: list[_Piece]) -> list[BulkCard]:
    """Cards, with those that `=` repeats."""
    cards: list[BulkCard] = []
    pattern: list[str] = []
    for piece in pieces:
        if piece.name[:1] != "=":
            cards.append(BulkCard(piece.name, tuple(piece.fields), *piece.at[:2]))
            continue
        if not cards:
            raise piece.at.error("'=' repeats the card above, and there is none")
        repeats = _REPEATS.match(piece.name)
        if not repeats:
            pattern = piece.fields
        elif int(repeats[1]) > MOST_REPETITIONS:
            raise piece.at.error(f"'{piece.name}' repeats over {MOST_REPETITIONS} times")
        for _ in range(int(repeats[1]) if repeats else 1):
            cards.append(_repeated(cards[-1], pattern, piece))
    return cards


def _repeated(above: BulkCard, pattern: list[str], piece: _Piece) -> BulkCard:
    """The repeated card: '=' copies a field, '==' all that follow, '*(x)' adds x, other fields replace."""
    fields: list[str] = []
    for place in range(max(len(above.fields), len(pattern))):
        old = above.fields[place] if place < len(above.fields) else ""
        word = pattern[place] if place < len(pattern) else ""
        if word == "==":
            fields += above.fields[place:]
            break
        grows = _GROWS.match(word)
        if word == "=":
            fields.append(old)
        elif grows:
            fields.append(_sum(old, grows[1], piece))
        else:
            fields.append(word)
    return BulkCard(above.name, tuple(fields), *piece.at[:2])


def _sum(old: str, step: str, piece: _Piece) -> str:
    """A field and a step; a blank field counts as zero."""
    old = old or "0"
    try:
        return str(plain_integer(old) + plain_integer(step))
    except ValueError:
        pass
    try:
        return repr(bulk_real(old) + bulk_real(step))
    except ValueError:
        message = f"'*({step[:20]})' adds to '{old[:20]}'; both must be numbers"
        raise piece.at.error(message) from None


def _card_name(line: RawLine, first: str) -> str:
    # meshio writes quadratic elements as CTETRA_, CHEXA_.
    name = first.rstrip("* ").removesuffix("_").upper()
    if not _CARD_NAME.match(name) and name != "=" and not _REPEATS.match(name):
        raise line.error(f"'{first[:20]}' is not the name of a card; is this a Nastran bulk data file?")
    return name


def _split(line: RawLine) -> tuple[str, list[str], str]:
    """First field, data fields (8, or 4 large ones) and continuation label of a line."""
    text = line.text
    if "," in text and _is_free(text):
        words = [word.strip() for word in text.split(",")]
        if not has_no_effect(_name_of(words[0])):  # blanks separate fields as commas do
            words = [field for word in words for field in (word.split() or [""])]
        width = 4 if "*" in words[0] else 8
        if any(words[width + 2 :]) and not has_no_effect(_name_of(words[0])):
            what = "large fields" if width == 4 else "fields"
            raise line.error(
                f"{len(words)} {what}; a line has a name, {width} of them and a label: continue it on the "
                "next line"
            )
        data = words[1 : width + 1]
        last = words[width + 1] if len(words) > width + 1 else ""
        return words[0], data + [""] * (width - len(data)), last
    first = text[:8].strip()
    if "*" in first:
        data = [text[i : i + 16].strip() for i in (8, 24, 40, 56)]
    else:
        data = [text[i : i + 8].strip() for i in range(8, min(len(text), 72), 8)]
        data += [""] * (8 - len(data))
    # A label in column 73 may lack its '+'; the continuation has '+' in place of the first character.
    label = text[72:80].strip()
    return first, data, label and f"+{label[1:]}"


def _is_free(text: str) -> bool:
    """Whether commas separate the fields of a line; the text of an equation may also contain commas."""
    name = _name_of(text)
    return "," in text[:10] or text[0] in "+*" or (name != "" and not has_no_effect(name))


def _name_of(text: str) -> str:
    """Name of the card at the start of a line."""
    return text[:8].partition(" ")[0].rstrip("*").upper()


def _sections(
    path: Path, absent: list[BulkCard] | None
) -> tuple[list[RawLine], list[tuple[str, str, list[RawLine]]], bool]:
    """Lines above the cards; kind, name and lines of each section of cards; whether the file has ENDDATA."""
    inclusions = Inclusions("export the model as text (.bdf)")
    lines = _expanded(path, path.parent, inclusions.lines(path), inclusions, 0)
    last = next((i for i, (_, _, text) in enumerate(lines) if _END.match(text)), len(lines))
    ended, lines = last < len(lines), _present(lines[:last], inclusions, absent)
    starts = [i for i, (_, _, text) in enumerate(lines) if _BEGIN.match(text)]
    above = lines[: starts[0]] if starts else []
    found: list[tuple[str, str, list[RawLine]]] = []
    if not starts:
        return above, [("", "", lines)], ended
    for start, stop in zip(starts, [*starts[1:], len(lines)], strict=True):
        named = {kind: name for kind, name in _PART.findall(lines[start][2].upper())}
        # SUPER = 1 MASSID = 300 is a mass case of a part, not the part itself.
        kind = "MASSID" if "MASSID" in named else next(iter(named), "")
        found.append((kind, named.get(kind, ""), lines[start + 1 : stop]))
    return above, found, ended


def _expanded(
    path: Path,
    main: Path,
    read: list[str],
    inclusions: Inclusions,
    depth: int,
) -> list[RawLine]:
    """Lines without comments and blank lines, with included files; `_MISSING` marks a missing one."""
    found: list[RawLine] = []
    lines = enumerate(read, start=1)
    for number, line in lines:
        text = line.partition("$")[0].rstrip()
        if not text:
            continue
        if "\t" in text:
            text = text.expandtabs(8)
        included = _INCLUDE.match(text) if text.lstrip()[:7].upper() == "INCLUDE" else None
        if not included:
            found.append(RawLine(path, number, text))
            continue
        name = included[1].strip() or next(lines, (0, ""))[1].strip()
        while name[:1] in ("'", '"') and name.count(name[0]) == 1:
            # A quoted name may extend over several lines.
            _, more = next(lines, (0, name[0]))
            name += more.strip()
        target = included_file(name.strip("'\" "), path.parent, main)
        if is_file(target):
            below = inclusions.included(path, number, target, depth + 1)
            found += _expanded(target, main, below, inclusions, depth + 1)
        else:
            found.append(RawLine(path, number, f"{_MISSING}{target}"))
    return found


def _present(lines: list[RawLine], inclusions: Inclusions, absent: list[BulkCard] | None) -> list[RawLine]:
    """The lines without missing files, which are added to `absent` or are errors, as in `read_bulk_data`."""
    begin = next((i for i, (_, _, text) in enumerate(lines) if _BEGIN.match(text)), 0)
    cend = next((i for i, (_, _, text) in enumerate(lines[:begin]) if _CEND.match(text)), 0)
    kept: list[RawLine] = []
    for place, line in enumerate(lines):
        target = line.text.removeprefix(_MISSING)
        if target == line.text:
            kept.append(line)
        elif place >= begin and absent is None:
            inclusions.included(line.path, line.number, Path(target), 1)  # raises
        elif absent is not None and place >= cend:
            fields = (target,) if place >= begin else (target, "CASE")
            absent.append(BulkCard("INCLUDE", fields, line.path, line.number))
    return kept
