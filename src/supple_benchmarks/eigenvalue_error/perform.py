"""`supple benchmark eigenvalue-error`: run, print the tables, write the report and the figures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from supple_benchmarks.eigenvalue_error.beam_frequencies import beam_frequencies
from supple_benchmarks.eigenvalue_error.figures import draw_figures
from supple_benchmarks.eigenvalue_error.mode_selection_study import (
    SelectionStudy,
    draw_studies,
    selection_studies,
    selection_table,
)
from supple_benchmarks.eigenvalue_error.problem import EigenvalueErrors
from supple_benchmarks.eigenvalue_error.report import report, tables
from supple_benchmarks.eigenvalue_error.run import BodyResult, run_eigenvalue_errors
from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.progress import Announce
from supple_benchmarks.table import Report

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; the report is rewritten after every body, so that finished bodies are not lost."""
    problem = EigenvalueErrors.quick() if quick else EigenvalueErrors()
    beams = beam_frequencies(problem)
    results: list[BodyResult] = []
    studies: list[SelectionStudy] = []

    def found(started: Announce) -> Iterator[Report]:
        for result in run_eigenvalue_errors(problem, started):
            results.append(result)
            yield report(results, beams)
        advance = started("mode selection")
        for study in selection_studies(problem):
            studies.append(study)
            advance(len(studies) / 3)
        yield report(results, beams, studies)

    keep_report(
        json or folder / "eigenvalue-error.json",
        found,
        lambda _: [*tables(results, beams), selection_table(studies)],
        lambda *_: draw_figures(results, folder) + draw_studies(studies, folder),
    )
