"""The tables of the intrinsic benchmark."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from supple_benchmarks.table import Table

__all__ = ["tables"]


def tables(report: Mapping[str, Any]) -> list[Table]:
    """The tables of the complete report: single numbers in the first, then one table per study."""
    flying = report["u_beam"]
    numbers = {
        "Phi_1": report["orthonormality"]["phi1"],
        "Phi_2": report["orthonormality"]["phi2"],
        "energy drift": report["energy_drift"],
        "small vibration of the box, from linear": report["box_beam"]["small_from_linear"],
        "order, elastica": report["elastica_order"],
        "order, centre of mass": flying["order"],
    }
    return [
        _rows("Errors of orthonormality, energy and a small vibration; convergence orders", [numbers]),
        _rows("The elastica, P L^2 / E I = 10: error of the tip over the length", report["elastica"]),
        _rows("The bend of 45 degrees", [dict(zip("xyz", report["simo45"]["tip"], strict=True))]),
        _rows("The box beam's frequencies, rad/s", report["box_beam"]["frequencies"]),
        _rows("The box on stations compared with its shell model", report["box_beam"]["against_shells"]),
        _rows("The U's centre of mass, by stations", [flying["com_error"]]),
        _rows("Truncated and residual modes of the U", flying["residualised"]),
        _rows("A strip by four methods against the elastica; the blade", report["agreement"]),
        _rows("Microseconds per step", report["speed"]),
    ]


def _rows(title: str, rows: list[dict[str, Any]]) -> Table:
    heads = list(dict.fromkeys(key for row in rows for key in row))
    return title, heads, [[_cell(row.get(head, "")) for head in heads] for row in rows]


def _cell(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
