"""`supple benchmark eigenvalue-error`: run, print the tables, write the report and the figures."""

from __future__ import annotations

from pathlib import Path

from supple.benchmark.eigenvalue_error import EigenvalueErrors, beam_frequencies, run_eigenvalue_errors
from supple.benchmark.eigenvalue_error_report import draw_figures, report, tables
from supple.benchmark.mode_selection_study import draw_studies, selection_studies, selection_table
from supple.cli.console import bar, console, print_table, progress_bars
from supple.storage import write_json

__all__ = ["benchmark_eigenvalue_error"]


def benchmark_eigenvalue_error(problem: EigenvalueErrors, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every body, so that a stop loses none."""
    target = json or folder / "eigenvalue-error.json"
    target.parent.mkdir(parents=True, exist_ok=True)
    results = []
    with progress_bars() as bars:
        beams = beam_frequencies(problem)
        for result in run_eigenvalue_errors(problem, lambda label: bar(bars, label)):
            results.append(result)
            write_json(target, report(results, beams))
        advance = bar(bars, "mode selection")
        studies = []
        for study in selection_studies(problem):
            studies.append(study)
            advance(len(studies) / 3)
        write_json(target, report(results, beams, studies))
        pictures = draw_figures(results, folder) + draw_studies(studies, folder)
    for title, heads, rows in [*tables(results, beams), selection_table(studies)]:
        print_table(title, heads, rows)
    console.print(f"report    {target}", highlight=False, soft_wrap=True)
    for picture in pictures:
        console.print(f"picture   {picture}", highlight=False, soft_wrap=True)
