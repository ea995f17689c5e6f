"""`supple benchmark intrinsic`: run, print the tables, write the report."""

from __future__ import annotations

from pathlib import Path

from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.intrinsic.figures import draw_figures
from supple_benchmarks.intrinsic.report import tables
from supple_benchmarks.intrinsic.run import run_intrinsic

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark, print its tables, draw its figures into `folder`.

    The report is written to `json`, or to intrinsic.json in `folder`.
    """
    target = json or folder / "intrinsic.json"
    keep_report(
        target,
        lambda started: run_intrinsic(quick, started),
        tables,
        lambda report: draw_figures(report, folder),
    )
