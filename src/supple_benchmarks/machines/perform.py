"""`supple benchmark quadruple-pendulum | slider-crank`: run, print the tables, write report and figures."""

from __future__ import annotations

from pathlib import Path

from supple.storage import write_json
from supple.terminal import bar, progress_bars
from supple_benchmarks.machines.figures import animation, draw_figures
from supple_benchmarks.machines.flexible_machine import FlexibleMachine
from supple_benchmarks.machines.report import report, tables
from supple_benchmarks.machines.study import Study, run_study
from supple_benchmarks.printed import print_files, print_tables

__all__ = ["perform"]


def perform(machine: FlexibleMachine, tolerances: tuple[float, ...], json: Path | None, folder: Path) -> None:
    """Run every variant of the machine; each run rewrites the report; motions are stored and reused."""
    target = json or folder / f"{machine.name}.json"
    target.parent.mkdir(parents=True, exist_ok=True)
    study: Study | None = None
    with progress_bars() as bars:
        for study in run_study(machine, folder / "motions", lambda label: bar(bars, label), tolerances):
            write_json(target, report(study))
        if study is None:
            return
        pictures = draw_figures(study, folder)
        pictures.append(
            animation(study, folder / f"{machine.name}.gif", bar(bars, "animation of the machine"))
        )
    print_tables(tables(study))
    print_files(target, pictures, motions=folder / "motions")
