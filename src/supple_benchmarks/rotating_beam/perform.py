"""`supple benchmark rotating-beam`: run, print the tables, write the report and the figures."""

from __future__ import annotations

from pathlib import Path

from supple.storage import write_json, write_solution
from supple.terminal import bar, progress_bars
from supple_benchmarks.printed import print_files, print_tables
from supple_benchmarks.rotating_beam.figures import animation, draw_figures
from supple_benchmarks.rotating_beam.problem import RotatingBeam
from supple_benchmarks.rotating_beam.report import report, tables
from supple_benchmarks.rotating_beam.run import BeamRun, run_rotating_beam

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every simulation, so that none is lost."""
    problem = RotatingBeam.quick() if quick else RotatingBeam()
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
        pictures.append(animation(run, folder / "beam.gif", bar(bars, "animation of the beam")))
    print_tables(tables(run))
    print_files(target, pictures, motions=folder / "motions")


def _store_latest(run: BeamRun, folder: Path) -> None:
    """Store the motion computed last: the last reduced one, or a full one not yet reduced."""
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
