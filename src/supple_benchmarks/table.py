"""A table of a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

__all__ = ["Report", "Row", "Table", "cell", "table_of"]

Report = Mapping[str, Any]
"""A report, or a part of it, by keys; ready for JSON."""
Row = dict[str, Any]
"""A row of a report, by column heads; ready for JSON."""
Table = tuple[str, list[str], list[list[str]]]
"""Title, column heads, rows."""


def table_of(title: str, rows: Sequence[Report]) -> Table:
    """The rows of a report, each a mapping from column heads to values, as a table."""
    heads = list(dict.fromkeys(head for row in rows for head in row))
    return title, heads, [[cell(row.get(head)) for head in heads] for row in rows]


def cell(value: object) -> str:
    """A value as text: numbers, also in lists, with four digits; a missing value (None) is empty."""
    if value is None:
        return ""
    if isinstance(value, list | tuple):
        return ", ".join(cell(each) for each in value)
    return f"{value:.4g}" if isinstance(value, float) else str(value)
