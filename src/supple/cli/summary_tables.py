"""The tables that a run prints, of the numbers that it writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rich.table import Table

from supple.integrate import Solution


def body_table(numbers: Mapping[str, Any]) -> Table:
    """One row per body: size and lowest frequencies."""
    table = Table(
        "body", "kind", "mass", "nodes", "coordinates", "held at", "lowest frequencies, Hz", title="Bodies"
    )
    for name, body in numbers["bodies"].items():
        cells = [name, body["kind"], _number(body.get("mass")), _count(body.get("nodes"))]
        coordinates = _count(body.get("coordinates"))
        if body["kind"] == "reduced":
            coordinates = f"{coordinates} of {body['freedoms']}"
        held = {"(its frame)": body.get("frequencies in the frame, Hz", ())} | body.get(
            "frequencies held, Hz", {}
        )
        for row, (place, frequencies) in enumerate(held.items()):
            head = [*cells, coordinates] if row == 0 else [""] * 5
            if len(frequencies) or row == 0:
                table.add_row(*head, place if len(frequencies) else "", _vector(frequencies, digits=4))
    return table


def place_table(numbers: Mapping[str, Any]) -> Table:
    """One row per axis of each tracked place."""
    table = Table(
        "place", "seen from", "axis", "largest deflection", "at time", "at the end", title="Tracked motion"
    )
    for name, place in numbers["tracked"].items():
        for axis, letter in enumerate("xyz"):
            head = [name, place["seen from"]] if axis == 0 else ["", ""]
            values = (place[key][axis] for key in ("largest deflection", "at time", "last deflection"))
            table.add_row(*head, letter, *(_number(value) for value in values))
    return table


def joint_table(numbers: Mapping[str, Any]) -> Table:
    """Force and moment on the second end of each joint."""
    table = Table(
        "joint",
        "on its second end",
        "largest",
        "at time",
        "at the end (x, y, z of the joint)",
        title="Joints",
    )
    for name, joint in numbers["joints"].items():
        for row, what in enumerate(what for what in ("force", "moment") if f"largest {what}" in joint):
            table.add_row(
                name if row == 0 else "",
                what,
                _number(joint[f"largest {what}"]),
                _number(joint[f"time of largest {what}"]),
                _vector(joint[f"last {what}"]),
            )
    return table


def correction_table(numbers: Sequence[Mapping[str, Any]]) -> Table:
    """One row a round and body."""
    table = Table(
        "body",
        "round",
        "coordinates",
        "estimated error",
        "allowed",
        "missing motion",
        "seconds",
        title="Self-correction",
    )
    for each in numbers:
        errors = (_error(each[key]) for key in ("estimated_error", "allowed", "indicator"))
        table.add_row(each["body"], str(each["round"]), str(each["size"]), *errors, f"{each['seconds']:.1f}")
    return table


def cost_line(solution: Solution) -> str:
    """Steps, iterations and seconds in one line."""
    cost = solution.statistics
    return (
        f"{cost.steps} steps, {cost.iterations} Newton iterations, {cost.rejected_steps} cuts; "
        f"{cost.seconds:.2f} s of simulation after {cost.compile_seconds:.1f} s of compilation"
    )


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"


def _count(value: int | None) -> str:
    return "" if value is None else str(value)


def _vector(values: Sequence[float] | np.ndarray, digits: int = 5) -> str:
    return "  ".join(f"{value:.{digits}g}" for value in values)


def _error(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.2e}"
