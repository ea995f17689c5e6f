"""Final output of every benchmark: its tables, and the paths of its files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.table import Table as ShownTable

from supple.terminal import console
from supple_benchmarks.table import Table

__all__ = ["print_files", "print_tables"]

_WORDS = {
    *("model", "columns", "basis", "one", "other", "body", "element", "motion", "interfaces"),
    *("case", "quantity", "failure"),
}
"""Heads of text columns, which are aligned left; numbers are aligned right."""


def print_tables(tables: Iterable[Table]) -> None:
    """Print tables, each a title, column heads and rows."""
    for title, heads, rows in tables:
        shown = ShownTable(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
        for head in heads:
            shown.add_column(head, justify="left" if head in _WORDS else "right", no_wrap=True)
        for row in rows:
            shown.add_row(*row)
        console.print(shown)


def print_files(report: Path, pictures: Iterable[Path], *, motions: Path | None = None) -> None:
    """Print the paths of the report, of the folder of motions if there is one, and of every picture."""
    named = [("report", report), *([("motions", motions)] if motions else [])]
    for what, path in [*named, *(("picture", each) for each in pictures)]:
        console.print(f"{what:<9} {path}", highlight=False, soft_wrap=True)
