"""`supple benchmark invariance`: run, print the tables, write the report."""

from __future__ import annotations

from pathlib import Path

from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.invariance.figures import draw_figures
from supple_benchmarks.invariance.report import tables
from supple_benchmarks.invariance.run import run_invariance

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark, print its tables, draw its figure into `folder`.

    The report is written to `json`, or to invariance.json in `folder`.
    """
    target = json or folder / "invariance.json"
    keep_report(
        target,
        lambda started: run_invariance(quick, started),
        tables,
        lambda report: draw_figures(report, folder),
    )
