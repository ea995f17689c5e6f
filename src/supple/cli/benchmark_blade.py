"""`supple benchmark blade`: run, print the tables, write the report and the pictures."""

from __future__ import annotations

from pathlib import Path

from supple.benchmark.blade_benchmark import BladeBenchmark, BladeRun, run_blade
from supple.benchmark.blade_figures import draw_figures, film
from supple.benchmark.blade_report import report, tables
from supple.cli.console import bar, console, print_table, progress_bars
from supple.storage import write_json


def benchmark_blade(benchmark: BladeBenchmark, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every simulation, so that a stop loses none."""
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
        pictures.append(film(run, folder / "blade.gif", bar(bars, "film of the blade")))
    for title, heads, rows in tables(run):
        print_table(title, heads, rows)
    if run.batch is not None:
        batch = run.batch
        console.print(
            f"batch     {batch.cases} load cases of {batch.duration:g} s in {batch.seconds:.1f} s on the "
            f"{batch.device}: {batch.cases_per_s:.2f} cases/s, {batch.size} coordinates",
            highlight=False,
        )
    console.print(f"report    {target}", highlight=False, soft_wrap=True)
    console.print(f"motions   {folder / 'motions'}", highlight=False, soft_wrap=True)
    for picture in pictures:
        console.print(f"picture   {picture}", highlight=False, soft_wrap=True)
