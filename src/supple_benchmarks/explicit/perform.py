"""`supple benchmark explicit`: run, print the tables, write the report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from supple.storage import write_json
from supple.terminal import bar, progress_bars
from supple_benchmarks.explicit.report import tables
from supple_benchmarks.explicit.run import run_explicit
from supple_benchmarks.printed import print_files, print_tables

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every study, so that a stop loses none."""
    target = json or folder / "explicit.json"
    target.parent.mkdir(parents=True, exist_ok=True)
    report: dict[str, Any] = {}
    with progress_bars() as bars:
        for report in run_explicit(quick, lambda label: bar(bars, label)):
            write_json(target, report)
    print_tables(tables(report))
    print_files(target, [])
