"""`supple benchmark invariance`: run, print the tables, write the report and the figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from supple.storage import write_json
from supple.terminal import bar, progress_bars
from supple_benchmarks.invariance.figures import draw_figures
from supple_benchmarks.invariance.report import tables
from supple_benchmarks.invariance.run import run_invariance
from supple_benchmarks.printed import print_files, print_tables

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every study, so that a stop loses none."""
    target = json or folder / "invariance.json"
    target.parent.mkdir(parents=True, exist_ok=True)
    report: dict[str, Any] = {}
    with progress_bars() as bars:
        for report in run_invariance(quick, lambda label: bar(bars, label)):
            write_json(target, report)
    pictures = draw_figures(report, folder)
    print_tables(tables(report))
    print_files(target, pictures)
