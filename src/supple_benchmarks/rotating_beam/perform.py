"""`supple benchmark rotating-beam`: run, print the tables, write the report and the figures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from supple.storage import write_solution
from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.progress import Announce
from supple_benchmarks.rotating_beam.figures import animation, draw_figures
from supple_benchmarks.rotating_beam.problem import RotatingBeam
from supple_benchmarks.rotating_beam.report import report, tables
from supple_benchmarks.rotating_beam.run import BeamRun, run_rotating_beam

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every simulation, so that none is lost."""
    problem = RotatingBeam.quick() if quick else RotatingBeam()
    motions = folder / "motions"

    def runs(started: Announce) -> Iterator[BeamRun]:
        for run in run_rotating_beam(problem, started):
            _store_latest(run, motions)
            yield run

    def draw(run: BeamRun, started: Announce) -> list[Path]:
        pictures = draw_figures(run, folder)
        return [*pictures, animation(run, folder / "beam.gif", started("animation of the beam"))]

    keep_report(json or folder / "rotating-beam.json", runs, tables, draw, report=report, motions=motions)


def _store_latest(run: BeamRun, motions: Path) -> None:
    """Store the motion computed last: the last reduced one, or a full one not yet reduced."""
    full = run.full[-1]
    reduced = [one for one in run.reduced if one.full is full]
    label = f"{full.frame}_{full.kinematics}_{full.omega:g}"
    solution = full.solution
    if reduced:
        latest = reduced[-1]
        basis = latest.basis
        label += f"_{basis.n_linear}+{basis.n_added}_{basis.derivatives_name}"
        solution = latest.solution
    motions.mkdir(parents=True, exist_ok=True)
    write_solution(motions / f"{label}.h5", solution, case=f"rotating beam {label}")
