"""The rounds of a self-correction as numbers, for a table or a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from supple.error.correction_rounds import Round

__all__ = ["best_round", "correction_numbers"]


def correction_numbers(rounds: Sequence[Round]) -> list[dict[str, Any]]:
    """One record per round and body, in their order; errors that are not finite are None."""
    met: dict[str, int] = {}
    numbers = []
    for each in rounds:
        name = each.body.name
        met[name] = met.get(name, -1) + 1 if each.number is None else each.number
        numbers.append(
            {
                "body": name,
                "round": met[name],
                "size": each.size,
                "estimated_error": _finite(each.estimated_error),
                "allowed": _finite(each.allowed),
                "indicator": _finite(each.indicator),
                "seconds": each.seconds,
                "useless": each.useless,
                "unconfirmed": each.unconfirmed,
            }
        )
    return numbers


def best_round(numbers: Sequence[Mapping[str, Any]]) -> int:
    """Number of the round with the smallest ratio of error to allowed error; the last one if all are unknown.

    With several bodies, the largest ratio of a round counts. An unconfirmed error counts as unknown.
    """
    worst: dict[int, float] = {}
    for each in numbers:
        unknown = each["estimated_error"] is None or each["unconfirmed"]
        error = np.inf if unknown else each["estimated_error"] / each["allowed"]
        worst[each["round"]] = max(worst.get(each["round"], 0.0), error)
    return min(worst, key=lambda number: (worst[number], -number))


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
