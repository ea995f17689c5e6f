"""`supple benchmark sweep`: run, print the table, write the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from supple.storage import write_json
from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.progress import Announce
from supple_benchmarks.sweep.run import run_benchmark
from supple_benchmarks.table import Report, Row, Table, cell

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; write its report to the folder or a named file, and details to `details.json`."""
    details: Row = {}

    def contract(started: Announce) -> Iterator[Row]:
        for report, found in run_benchmark(quick, folder, started):
            details.update(found)
            write_json(folder / "details.json", details)
            yield report

    keep_report(json or folder / "sweep.json", contract, lambda report: _tables(report | details))


def _tables(report: Report) -> Iterator[Table]:
    rows = [[name, cell(value)] for name, value in _flat(report) if name != "machine"]
    yield "Sweep of a flexible arm", ["quantity", "value"], rows


def _flat(report: Report) -> Iterator[tuple[str, Any]]:
    for name, value in report.items():
        if isinstance(value, Mapping) and name != "machine":
            yield from ((f"{name}: {inner}", own) for inner, own in value.items())
        else:
            yield name, value
