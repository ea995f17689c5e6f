"""`supple benchmark trust`: run, print the tables, write the report after every case."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from supple.storage import write_json
from supple.terminal import bar, progress_bars
from supple_benchmarks.printed import print_files, print_tables
from supple_benchmarks.trust.report import tables
from supple_benchmarks.trust.run import run_trust

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; what is finished is kept in the folder, so that a stop loses one case at most."""
    report_path = json or folder / "report.json"
    report: dict[str, Any] = {}
    with progress_bars() as bars:
        for report in run_trust(quick, folder, lambda label: bar(bars, label)):
            write_json(report_path, report)
    print_tables(tables(report))
    print_files(report_path, [])
