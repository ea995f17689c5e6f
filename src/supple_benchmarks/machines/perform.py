"""`supple benchmark quadruple-pendulum | slider-crank`: run, print the tables, write report and figures."""

from __future__ import annotations

from pathlib import Path

from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.machines.figures import animation, draw_figures
from supple_benchmarks.machines.flexible_machine import FlexibleMachine
from supple_benchmarks.machines.report import report, tables
from supple_benchmarks.machines.study import Study, run_study
from supple_benchmarks.progress import Announce

__all__ = ["perform"]


def perform(machine: FlexibleMachine, tolerances: tuple[float, ...], json: Path | None, folder: Path) -> None:
    """Run every variant of the machine; each run rewrites the report; motions are stored and reused."""
    motions = folder / "motions"

    def draw(study: Study, started: Announce) -> list[Path]:
        pictures = draw_figures(study, folder)
        moving = started("animation of the machine")
        return [*pictures, animation(study, folder / f"{machine.name}.gif", moving)]

    keep_report(
        json or folder / f"{machine.name}.json",
        lambda started: run_study(machine, motions, started, tolerances),
        tables,
        draw,
        report=report,
        motions=motions,
    )
