"""Paths to the numbers of a case file: `load[0].law.amplitude`, `joint.shaft.law.speed`, `gravity[2]`.

A number with a name is a parameter, which can be changed in an exported machine.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import Field

from supple.cases.shared_rules import joint_label, usable_names
from supple.errors import CaseError
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, Raw, nearest_hint, tables

_PART = re.compile(r"\.?([^.\[\]]+)|\[(\d+)\]")


def parameter_path(text: str, raw: Raw) -> KeyPath:
    """The keys and positions (from 0) of a path in the tables of a case.

    Items of an array are given by their position, `load[0]`, or by their name, `body.blade`; joints without
    a name by their label. The last key may be absent, if it has a default.

    Raises
    ------
    CaseError   a path that does not exist
    """
    words = _words(text)
    place: KeyPath = ()
    found: Any = raw
    while words:
        if isinstance(found, list):
            words = _with_label(words, found)
        word = words.pop(0)
        if isinstance(found, list):
            number = word if isinstance(word, int) else _named(found, word, text)
            if not number < len(found):
                raise CaseError(
                    f"{text}: there is no item [{number}]: the {len(found)} items are counted from 0"
                )
            place, found = (*place, number), found[number]
        elif isinstance(found, Mapping) and isinstance(word, str):
            if word not in found and words:
                raise CaseError(
                    f"{text}: there is no {word!r}{nearest_hint(word, found)}; it has: "
                    f"{', '.join(found) or 'nothing'}"
                )
            place, found = (*place, word), found.get(word)
        else:
            raise CaseError(f"{text}: there is nothing below {'.'.join(map(str, place))} of the case file")
    return place


def number_at(place: KeyPath, raw: Raw) -> float | None:
    """The number at a path of a case; None if there is none."""
    found: Any = raw
    for key in place:
        found = found.get(key) if isinstance(found, Mapping) else found[key]
    return float(found) if isinstance(found, int | float) and not isinstance(found, bool) else None


def with_value(raw: Any, place: KeyPath, value: Any) -> Any:
    """The tables with another value at a path; unchanged parts are shared, not copied."""
    if not place:
        return value
    key, *rest = place
    if isinstance(raw, Mapping):
        return {**raw, key: with_value(raw.get(key), tuple(rest), value)}
    return [with_value(each, tuple(rest), value) if i == key else each for i, each in enumerate(raw)]


def _words(text: str) -> list[str | int]:
    words, at = list[str | int](), 0
    while at < len(text):
        part = _PART.match(text, at)
        if part is None or (at == 0 and text.startswith((".", "["))):
            raise CaseError(
                f"{text!r} is not a path of a case file, such as joint.shaft.law.speed or load[0].vector[2]"
            )
        name, number = part.groups()
        words.append(name if number is None else int(number))
        at = part.end()
    if not words:
        raise CaseError("an empty path is not a key of a case file; give one such as joint.shaft.law.speed")
    return words


def _with_label(words: list[str | int], items: Sequence[object]) -> list[str | int]:
    """The words with the label of an item as one word: `fixed ground - arm.root` contains a dot."""
    for end in range(2, len(words) + 1):
        if all(isinstance(word, str) for word in words[:end]):
            label = ".".join(map(str, words[:end]))
            if any(_name(each) == label for each in items):
                return [label, *words[end:]]
    return words


def _named(items: Sequence[object], name: str, text: str) -> int:
    names = [_name(each) for each in items]
    if name not in names:
        known = [each for each in names if each]
        raise CaseError(
            f"{text}: no item is named {name!r}{nearest_hint(name, known)}; "
            f"names: {', '.join(known) or 'none'}; the first item is [0]"
        )
    return names.index(name)


def _name(item: object) -> str:
    if not isinstance(item, Mapping):
        return ""
    if "name" not in item and {"kind", "first", "second"} <= item.keys():
        return joint_label(item["kind"], item["first"], item["second"])
    return str(item.get("name", ""))


class ParameterTable(CheckedTable):
    """A named number of the case."""

    name: str = Field(description="name of the variable in the FMU")
    path: str = Field(description="key that has the number, such as load[0].law.amplitude")
    unit: str = Field("", description="unit of the number in the FMU")


def _lead_to_numbers(raw: Raw) -> Mistakes:
    for place, each in tables(raw, "parameter"):
        path = each.get("path")
        if not isinstance(path, str):
            continue
        try:
            there = parameter_path(path, raw)
        except CaseError as error:
            yield (*place, "path"), str(error)
            continue
        if number_at(there, raw) is None:
            yield (
                (*place, "path"),
                f"{path} is not a number in this file; write it there, even if it is the default",
            )


RULES = (_lead_to_numbers, lambda raw: usable_names(raw, "parameter"))
