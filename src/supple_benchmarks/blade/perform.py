"""`supple benchmark blade`: run, print the tables, write the report and the pictures."""

from __future__ import annotations

from pathlib import Path

from supple.storage import write_json
from supple.terminal import bar, console, progress_bars
from supple_benchmarks.blade.figures import animation, draw_figures
from supple_benchmarks.blade.report import report, tables
from supple_benchmarks.blade.run import BladeBenchmark, BladeRun, run_blade
from supple_benchmarks.printed import print_files, print_tables

__all__ = ["perform"]


def perform(benchmark: BladeBenchmark, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every simulation."""
    target = json or folder / "blade.json"
    target.parent.mkdir(parents=True, exist_ok=True)
    run: BladeRun | None = None
    with progress_bars() as bars:
        for run in run_blade(benchmark, folder / "motions", lambda label: bar(bars, label)):
            write_json(target, report(run))
        if run is None:
            return
        drawn = bar(bars, "pictures")
        pictures = draw_figures(run, folder)
        drawn(1.0)
        pictures.append(animation(run, folder / "blade.gif", bar(bars, "animation of the blade")))
    print_tables(tables(run))
    if run.batch is not None:
        batch = run.batch
        console.print(
            f"batch     {batch.cases} load cases of {batch.duration:g} s in {batch.seconds:.1f} s on the "
            f"{batch.device}: {batch.cases_per_s:.2f} cases/s, {batch.size} coordinates",
            highlight=False,
        )
    print_files(target, pictures, motions=folder / "motions")
