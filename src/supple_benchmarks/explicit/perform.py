"""`supple benchmark explicit`: run, print the tables, write the report."""

from __future__ import annotations

from pathlib import Path

from supple_benchmarks.explicit.report import tables
from supple_benchmarks.explicit.run import run_explicit
from supple_benchmarks.growing_report import keep_report

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark, print its tables; write the report to `json`, or to explicit.json in `folder`."""
    target = json or folder / "explicit.json"
    keep_report(target, lambda started: run_explicit(quick, started), tables)
