"""Report of a benchmark with several studies: rewritten after each study, printed at the end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from supple.storage import write_json
from supple.terminal import bar, progress_bars
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.printed import print_files, print_tables
from supple_benchmarks.progress import Announce
from supple_benchmarks.table import Report, Row, Table

__all__ = ["Study", "keep_report", "studied"]

Found = TypeVar("Found")
Study = tuple[str, Callable[[bool], Any]]
"""Name of a study, and the function that performs it, in its quick form or whole."""


def keep_report(
    target: Path,
    studies: Callable[[Announce], Iterator[Found]],
    tables: Callable[[Found], Iterable[Table]],
    draw: Callable[[Found, Announce], Sequence[Path]] = lambda _found, _started: [],
    *,
    report: Callable[[Found], Report] = lambda found: found,
    motions: Path | None = None,
) -> Found:
    """Write the report after each study, so that an interruption loses one study at most.

    target : path of the report
    studies : generator that performs the studies, and yields everything found so far after each
    tables, draw : functions of all that is found; return its tables and the paths of its pictures
    report : the report of what is found
    motions : folder of stored motions
    Returns all that is found.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    found: Found | None = None
    with progress_bars() as bars:
        started = partial(bar, bars)
        for found in studies(started):
            write_json(target, report(found))
        if found is None:
            raise ValueError("a benchmark has at least one study")
        pictures = draw(found, started)
    print_tables(tables(found))
    print_files(target, pictures, motions=motions)
    return found


def studied(quick: bool, studies: Mapping[str, Study], announce: Announce) -> Iterator[Row]:
    """Perform the studies, by their keys; yield the report, ready for JSON, after each.

    Tests read the keys of the reports, so they must not change.
    """
    report: Row = {"quick": quick, "machine": describe_computer()}
    for key, (label, study) in studies.items():
        progress = announce(label)
        progress(0.0)
        found = study(quick)
        report[key] = list(found) if isinstance(found, Iterator) else found
        progress(1.0)
        yield report
