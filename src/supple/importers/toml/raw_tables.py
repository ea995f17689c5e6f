"""The tables of a TOML file as the TOML reader returns them, for rules on the combination of keys.

The rules read the raw data, not the checked tables. Therefore all rules run even if other keys are wrong, and
all mistakes are reported at once. The schema reports values of a wrong type; rules ignore them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from supple.errors import nearest_name
from supple.importers.toml.line_index import KeyPath

__all__ = [
    "Mistakes",
    "Raw",
    "Rule",
    "RuleOfOne",
    "names",
    "nearest_hint",
    "on_each",
    "table",
    "tables",
    "unknown",
]

Raw = Mapping[str, Any]
Mistakes = Iterator[tuple[KeyPath, str]]
"""Paths of keys, each with the mistake and the remedy."""
Rule = Callable[[Raw], Mistakes]
"""A rule on a whole file."""
RuleOfOne = Callable[[KeyPath, Raw], Mistakes]
"""A rule on one table, with its path."""


def tables(raw: Raw, key: str, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Raw]]:
    """The items of an array of tables with their paths; nothing if the value of `key` is no array."""
    items = raw.get(key)
    for position, item in enumerate(items if isinstance(items, list) else []):
        if isinstance(item, Mapping):
            yield (*path, key, position), item


def table(raw: Raw, key: str) -> Raw:
    """The table under a key; an empty one if its value is no table."""
    inner = raw.get(key)
    return inner if isinstance(inner, Mapping) else {}


def on_each(key: str, *rules: RuleOfOne) -> Rule:
    """The rules on one table as a rule on all tables of an array."""

    def on_all(raw: Raw) -> Mistakes:
        for path, item in tables(raw, key):
            for rule in rules:
                yield from rule(path, item)

    return on_all


def names(raw: Raw, key: str) -> list[str]:
    """The names of the items of an array of tables."""
    return [str(item.get("name")) for _, item in tables(raw, key)]


def nearest_hint(name: str, known: Iterable[str]) -> str:
    """`, did you mean 'NEAREST'?` or nothing when no known name is near."""
    nearest = nearest_name(name, known)
    return f", did you mean {nearest!r}?" if nearest else ""


def unknown(what: str, name: str, known: Sequence[str]) -> str:
    """The message for a name that does not exist."""
    listed = ", ".join(dict.fromkeys(known)) or "none"
    return f"there is no {what} named {name!r}{nearest_hint(name, known)}; there is: {listed}"
