"""`supple benchmark eigenvalue-error`: run, print the tables, write the report and the figures."""

from __future__ import annotations

from pathlib import Path

from supple.storage import write_json
from supple.terminal import bar, progress_bars
from supple_benchmarks.eigenvalue_error.beam_frequencies import beam_frequencies
from supple_benchmarks.eigenvalue_error.figures import draw_figures
from supple_benchmarks.eigenvalue_error.mode_selection_study import (
    draw_studies,
    selection_studies,
    selection_table,
)
from supple_benchmarks.eigenvalue_error.problem import EigenvalueErrors
from supple_benchmarks.eigenvalue_error.report import report, tables
from supple_benchmarks.eigenvalue_error.run import run_eigenvalue_errors
from supple_benchmarks.printed import print_files, print_tables

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every body, so that finished bodies are not lost."""
    problem = EigenvalueErrors.quick() if quick else EigenvalueErrors()
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
    print_tables([*tables(results, beams), selection_table(studies)])
    print_files(target, pictures)
