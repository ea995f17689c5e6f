"""`supple benchmark trust`: run case by case, print the tables, write the report.

The report has statistics of the rounds and the acceptances.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from supple.storage import write_json
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.growing_report import keep_report
from supple_benchmarks.progress import Announce
from supple_benchmarks.table import Row
from supple_benchmarks.trust.assessment import assess
from supple_benchmarks.trust.cases import CASES, QUICK
from supple_benchmarks.trust.exact_beams import EXACT_BEAMS, ExactBeamCase, assess_by_exact_beam
from supple_benchmarks.trust.report import tables
from supple_benchmarks.trust.trust_case import file_name

__all__ = ["coverage", "perform"]

OVER = 1.1
"""An acceptance is wrong if the true error exceeds this multiple of the allowed error."""


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark; finished cases are stored in the folder and read again."""
    keep_report(json or folder / "report.json", partial(_assessed, quick, folder), tables)


def _assessed(quick: bool, folder: Path, announce: Announce) -> Iterator[Row]:
    """Yields the report, which `write_json` accepts, after every case; its keys must not change.

    folder : folder of full runs and of finished cases; those present are read instead of computed
    """
    report: Row = {"quick": quick, "machine": describe_computer(), "cases": [], "exact_beams": []}
    for case in [*QUICK] if quick else [*CASES, *EXACT_BEAMS]:
        progress = announce(case.name)
        progress(0.0)
        beam = isinstance(case, ExactBeamCase)
        stored = folder / ("exact-beams" if beam else "cases") / f"{file_name(case.name)}.json"
        if stored.exists():
            record = json.loads(stored.read_text(encoding="utf-8"))
        else:
            if isinstance(case, ExactBeamCase):
                record = assess_by_exact_beam(case, progress)
            else:
                record = assess(case, folder / "full-runs", progress)
            stored.parent.mkdir(parents=True, exist_ok=True)
            write_json(stored, record)
        progress(1.0)
        report["exact_beams" if beam else "cases"].append(record)
        report["coverage"] = coverage(report["cases"], report["exact_beams"])
        yield report


def coverage(cases: Sequence[Row], beams: Sequence[Row] = ()) -> Row:
    """Statistics of the estimates from the second round of a body on, and number of wrong acceptances.

    Missing estimates, and true errors of exactly zero, are left out; the share of sums includes `beams`.
    """
    ratios = []
    for case in cases:
        seen: set[str] = set()
        for each in case["rounds"]:
            later = each["body"] in seen
            seen.add(each["body"])
            if later and each["estimated"] is not None and each["true"]:
                ratios.append(each["estimated"] / each["true"])
    n = max(len(ratios), 1)
    finished = [case for case in cases if case["accepted"]]
    sums = [case["stated_total"] / case["true_total"] for case in [*finished, *beams] if case["true_total"]]
    return {
        "rounds": len(ratios),
        "within_0.7_1.4": sum(0.7 <= ratio <= 1.4 for ratio in ratios) / n,
        "below_0.5": sum(ratio < 0.5 for ratio in ratios) / n,
        "accepted": len(finished),
        "accepted_over_limit": sum(case["true_total"] > OVER * case["allowed"] for case in finished),
        "sums_within_0.5_2": sum(0.5 <= each <= 2.0 for each in sums) / max(len(sums), 1),
    }
