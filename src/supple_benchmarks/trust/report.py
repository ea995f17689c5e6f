"""The tables of the trust benchmark."""

from __future__ import annotations

from supple.integrate import PARTS
from supple_benchmarks.table import Report, Table

__all__ = ["tables"]


def tables(report: Report) -> list[Table]:
    """Tables of the cases and their totals."""
    heads = (
        *("body", "freedoms", "coordinates", "estimated / true", "sum", "true", "allowed"),
        *PARTS,
        "estimator / run",
    )
    rows = []
    for case in report["cases"]:
        sizes = [str(each["size"]) for each in case["rounds"]]
        ratios = [_ratio(each) for each in case["rounds"]]
        accepted = case["accepted"]
        rows.append(
            [
                case["name"],
                str(case["freedoms"]),
                sizes[-1] if sizes else "",
                " ".join(ratios),
                _cell(case.get("stated_total")) if accepted else "rejected",
                _cell(case["true_total"]),
                _cell(case["allowed"]),
                *(_cell(case["parts"][part]) for part in PARTS),
                _cost(case.get("cost")),
            ]
        )
    shares = [[name, f"{value:.3g}"] for name, value in report["coverage"].items()]
    beams = [
        [
            each["name"],
            str(each["coordinates"]),
            *(_cell(each["parts"][part]) for part in PARTS),
            _cell(each["stated_total"]),
            _cell(each["true_total"]),
        ]
        for each in report["exact_beams"]
    ]
    return [
        ("Self-correcting runs against full runs", list(heads), rows),
        ("Fixed bases against exact beams", ["beam", "coordinates", *PARTS, "sum", "true"], beams),
        ("Totals", ["quantity", "value"], shares),
    ]


def _ratio(each: Report) -> str:
    if each["estimated"] is None or not each["true"]:
        return "-"
    return f"{each['estimated'] / each['true']:.2f}"


def _cost(cost: Report | None) -> str:
    return "" if cost is None else f"{cost['estimator_seconds'] / cost['run_seconds']:.2g}"


def _cell(value: float | None) -> str:
    return "" if value is None else f"{value:.2g}"
