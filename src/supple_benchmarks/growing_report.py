"""Report of a benchmark with several studies: rewritten after each study, printed at the end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from supple.storage import write_json
from supple.terminal import bar, progress_bars
from supple_benchmarks.printed import print_files, print_tables
from supple_benchmarks.table import Table

__all__ = ["Report", "StudyBar", "keep_report"]

Report = Mapping[str, Any]
StudyBar = Callable[[str], Any]
"""Creates the progress display of a study from its name."""


def keep_report(
    target: Path,
    studies: Callable[[StudyBar], Iterator[Report]],
    tables: Callable[[Any], Iterable[Table]],
    draw: Callable[[Any], Sequence[Path]] = lambda _: [],
) -> Report:
    """Write the report after each study, so that an interruption loses one study at most.

    target : path of the report
    studies : generator that performs the studies, and yields the whole report after each
    tables, draw : functions of the complete report; return its tables and the paths of its pictures
    Returns the complete report.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    report: Report = {}
    with progress_bars() as bars:
        for report in studies(lambda label: bar(bars, label)):
            write_json(target, report)
    pictures = draw(report)
    print_tables(tables(report))
    print_files(target, pictures)
    return report
