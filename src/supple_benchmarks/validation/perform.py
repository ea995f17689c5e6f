"""`supple benchmark validation`: compute every case, print the table, write the report."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from time import perf_counter

from supple.errors import AccuracyError
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.progress import Announce
from supple_benchmarks.table import Row
from supple_benchmarks.validation.report import outside, tables
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["perform", "run_cases"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Compute the cases, print their table, and write the report after each case.

    quick : leave out the cases with quick=False
    json : path of the report; None: validation.json in `folder`

    Raises AccuracyError that names the rows with errors above the allowed ones, and the failed cases.
    """
    # Imported here, so that the commands load without the modules of the topics.
    from supple_benchmarks.validation.every_case import CASES

    cases = [case for case in CASES if case.quick or not quick]
    target = json or folder / "validation.json"
    report = keep_report(target, lambda started: run_cases(cases, quick, started), tables)
    if rows := outside(report):
        named = "; ".join(f"{row['name']}: {row.get('failure') or row['quantity']}" for row in rows)
        raise AccuracyError(
            f"{len(rows)} of {len(report['cases'])} rows exceed their allowed errors or failed: {named}"
        )


def run_cases(cases: Iterable[ValidationCase], quick: bool, announce: Announce) -> Iterator[Row]:
    """Yield the whole report, ready for JSON, after each case; the keys of its rows must not change.

    announce : called with the name of the next case; returns the callback for its progress
    A case that raises an exception gets one row with its `failure` and without numbers; the next cases are
    still computed.
    """
    report: Row = {"quick": quick, "machine": describe_computer(), "cases": [], "seconds": {}}
    for case in cases:
        done = announce(case.name)
        done(0.0)
        began = perf_counter()
        report["cases"] += _rows(case)
        report["seconds"][case.name] = perf_counter() - began
        done(1.0)
        yield report


def _rows(case: ValidationCase) -> list[Row]:
    try:
        return [_row(case.name, each) for each in case.compare()]
    except Exception as error:
        nothing = dict.fromkeys(("value", "reference", "error", "allowed"))
        failure = f"{type(error).__name__}: {error}"
        return [{"name": case.name, "quantity": "", **nothing, "source": "", "failure": failure}]


def _row(name: str, each: Comparison) -> Row:
    return {
        "name": name,
        "quantity": each.quantity,
        "value": float(each.value),
        "reference": float(each.reference),
        "source": each.source,
        "error": float(each.error),
        "allowed": each.allowed,
    }
