"""`supple benchmark rotating-beam`: run, print the tables, write the report and the figures."""

from __future__ import annotations

from pathlib import Path

from supple.benchmark.rotating_beam import BeamRun, RotatingBeam, run_rotating_beam
from supple.benchmark.rotating_beam_report import draw_figures, film, report, tables
from supple.cli.console import bar, console, print_table, progress_bars
from supple.storage import write_json, write_solution

__all__ = ["benchmark_rotating_beam"]


def benchmark_rotating_beam(problem: RotatingBeam, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every simulation, so that a stop loses none."""
    target = json or folder / "rotating-beam.json"
    target.parent.mkdir(parents=True, exist_ok=True)
    run: BeamRun | None = None
    with progress_bars() as bars:
        for run in run_rotating_beam(problem, lambda label: bar(bars, label)):
            write_json(target, report(run))
            _store_latest(run, folder)
        if run is None:
            return
        pictures = draw_figures(run, folder)
        pictures.append(film(run, folder / "beam.gif", bar(bars, "film of the beam")))
    for title, heads, rows in tables(run):
        print_table(title, heads, rows)
    console.print(f"report    {target}", highlight=False, soft_wrap=True)
    console.print(f"motions   {folder / 'motions'}", highlight=False, soft_wrap=True)
    for picture in pictures:
        console.print(f"picture   {picture}", highlight=False, soft_wrap=True)


def _store_latest(run: BeamRun, folder: Path) -> None:
    """Keep the motion that has just been computed: the last reduced one, or a full one not yet reduced."""
    full = run.full[-1]
    reduced = [one for one in run.reduced if one.full is full]
    label = f"{full.frame}_{full.kinematics}_{full.omega:g}"
    solution = full.solution
    if reduced:
        latest = reduced[-1]
        label += f"_{latest.n_linear}+{latest.n_added}_{latest.derivatives}"
        solution = latest.solution
    motions = folder / "motions"
    motions.mkdir(parents=True, exist_ok=True)
    write_solution(motions / f"{label}.h5", solution, case=f"rotating beam {label}")
