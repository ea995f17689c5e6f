"""`supple benchmark blade`: run, print the tables, write the report and the pictures."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from supple.terminal import console
from supple_benchmarks.blade.figures import animation, draw_figures
from supple_benchmarks.blade.report import report, tables
from supple_benchmarks.blade.run import BladeBenchmark, BladeRun, run_blade
from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.progress import Announce

__all__ = ["perform"]


def perform(benchmark: BladeBenchmark, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every simulation."""
    motions = folder / "motions"

    def draw(run: BladeRun, started: Announce) -> list[Path]:
        drawn = started("pictures")
        pictures = draw_figures(run, folder)
        drawn(1.0)
        return [*pictures, animation(run, folder / "blade.gif", started("animation of the blade"))]

    target = json or folder / "blade.json"
    runs = partial(run_blade, benchmark, motions)
    batch = keep_report(target, runs, tables, draw, report=report, motions=motions).batch
    if batch is not None:
        console.print(
            f"batch     {batch.cases} load cases of {batch.duration:g} s in {batch.seconds:.1f} s on the "
            f"{batch.device}: {batch.cases_per_s:.2f} cases/s, {batch.size} coordinates",
            highlight=False,
        )
