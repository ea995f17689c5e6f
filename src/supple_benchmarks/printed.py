"""What every benchmark prints in the end: its tables, and where its files lie."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from supple.cli.console import console, print_table
from supple_benchmarks.table import Table

__all__ = ["print_files", "print_tables"]


def print_tables(tables: Iterable[Table]) -> None:
    """Print tables, each a title, column heads and rows."""
    for title, heads, rows in tables:
        print_table(title, heads, rows)


def print_files(report: Path, pictures: Iterable[Path], *, motions: Path | None = None) -> None:
    """Print the paths of the report, of the folder of motions if there is one, and of every picture."""
    named = [("report", report), *([("motions", motions)] if motions else [])]
    for what, path in [*named, *(("picture", each) for each in pictures)]:
        console.print(f"{what:<9} {path}", highlight=False, soft_wrap=True)
