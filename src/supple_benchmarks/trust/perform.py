"""`supple benchmark trust`: run, print the tables, write the report."""

from __future__ import annotations

from pathlib import Path

from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.trust.report import tables
from supple_benchmarks.trust.run import run_trust

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; finished cases are stored in the folder and read again."""
    target = json or folder / "report.json"
    keep_report(target, lambda started: run_trust(quick, folder, started), tables)
