"""The error of an equilibrium as a table of words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from supple.results.run_tables import TextTable
from supple.units import headed

__all__ = ["rest_error_table"]


def rest_error_table(numbers: Mapping[str, Any]) -> TextTable:
    """Error by the basis of each reduced body at rest; `numbers["errors"]` as of `RestError.plain`."""
    length = numbers["units"].get("length", "")
    rows = [
        [
            name,
            _number(error["rms"]),
            _number(error["worst"]),
            _number(error["largest displacement"]),
            _percent(error["relative"]),
            _percent(error["strain"]),
            _number(error["second sweep"]),
        ]
        for name, error in numbers["errors"].items()
    ]
    heads = (
        *("error of", headed("RMS over nodes", length), headed("worst node", length)),
        *(headed("largest displacement", length), "worst, %", "strain, %", "second sweep / first"),
    )
    return TextTable("Error of the basis at rest", heads, rows)


def _number(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.2e}"


def _percent(value: float | None) -> str:
    return "unknown" if value is None else f"{100 * value:.2g}"
