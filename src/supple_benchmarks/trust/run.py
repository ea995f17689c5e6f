"""The trust benchmark, case by case, and statistics of its rounds and acceptances."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from supple.storage import write_json
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.progress import Announce, Progress
from supple_benchmarks.trust.assessment import assess
from supple_benchmarks.trust.cases import CASES, QUICK
from supple_benchmarks.trust.exact_beams import EXACT_BEAMS, assess_by_exact_beam

__all__ = ["coverage", "run_trust"]

OVER = 1.1
"""An acceptance is wrong if the true error exceeds this multiple of the allowed error."""


def run_trust(quick: bool, folder: Path, announce: Announce) -> Iterator[dict[str, Any]]:
    """Yields the report, which `write_json` accepts, after every case; its keys must not change.

    folder : folder of full runs and of finished cases; those present are read instead of computed
    """
    report: dict[str, Any] = {"quick": quick, "machine": describe_computer(), "cases": [], "exact_beams": []}
    for case in QUICK if quick else CASES:
        progress = announce(case.name)
        stored = folder / "cases" / f"{case.file_name}.json"
        record = _stored_or(
            stored,
            progress,
            lambda case=case, progress=progress: assess(case, folder / "full-runs", progress),
        )
        report["cases"].append(record)
        report["coverage"] = coverage(report["cases"], report["exact_beams"])
        yield report
    for beam in () if quick else EXACT_BEAMS:
        progress = announce(beam.name)
        stored = folder / "exact-beams" / f"{beam.file_name}.json"
        record = _stored_or(
            stored, progress, lambda beam=beam, progress=progress: assess_by_exact_beam(beam, progress)
        )
        report["exact_beams"].append(record)
        report["coverage"] = coverage(report["cases"], report["exact_beams"])
        yield report


def _stored_or(path: Path, progress: Progress, compute: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """A record read from disk, or computed and stored."""
    progress(0.0)
    if path.exists():
        record = json.loads(path.read_text(encoding="utf-8"))
    else:
        record = compute()
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, record)
    progress(1.0)
    return record


def coverage(cases: Sequence[dict[str, Any]], beams: Sequence[dict[str, Any]] = ()) -> dict[str, Any]:
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
