"""`supple benchmark quadruple-pendulum | slider-crank`: run, print the tables, write report and figures."""

from __future__ import annotations

from pathlib import Path

from supple.benchmark.flexible_machine import FlexibleMachine
from supple.benchmark.tolerance_figures import draw_figures, film
from supple.benchmark.tolerance_report import report, tables
from supple.benchmark.tolerance_study import Study, run_study
from supple.cli.console import bar, console, print_table, progress_bars
from supple.storage import write_json

__all__ = ["benchmark_tolerances"]


def benchmark_tolerances(
    machine: FlexibleMachine, tolerances: tuple[float, ...], json: Path | None, folder: Path
) -> None:
    """Run the machine in every form; the report is rewritten after each run, motions are kept and reused."""
    target = json or folder / f"{machine.name}.json"
    target.parent.mkdir(parents=True, exist_ok=True)
    study: Study | None = None
    with progress_bars() as bars:
        for study in run_study(machine, folder / "motions", lambda label: bar(bars, label), tolerances):
            write_json(target, report(study))
        if study is None:
            return
        pictures = draw_figures(study, folder)
        pictures.append(film(study, folder / f"{machine.name}.gif", bar(bars, "film of the machine")))
    for title, heads, rows in tables(study):
        print_table(title, heads, rows)
    console.print(f"report    {target}", highlight=False, soft_wrap=True)
    console.print(f"motions   {folder / 'motions'}", highlight=False, soft_wrap=True)
    for picture in pictures:
        console.print(f"picture   {picture}", highlight=False, soft_wrap=True)
