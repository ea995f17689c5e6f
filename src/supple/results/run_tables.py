"""The numbers of a run as tables of words: bodies, tracked motion, joints, rounds of self-correction."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from supple.integrate import Statistics


class TextTable(NamedTuple):
    """A table ready to be printed; no word holds markup."""

    title: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]


def body_table(numbers: Mapping[str, Any]) -> TextTable:
    """Size and lowest frequencies, a row per body and place it is held at; numbers as of `summarize`."""
    heads = ("body", "kind", "mass", "nodes", "coordinates", "locks", "held at", "lowest frequencies, Hz")
    return TextTable(
        "Bodies", heads, [row for each in numbers["bodies"].items() for row in _body_rows(*each)]
    )


def _body_rows(name: str, body: Mapping[str, Any]) -> Iterable[list[str]]:
    cells = [name, body["kind"], _number(body.get("mass")), _count(body.get("nodes"))]
    coordinates = _count(body.get("coordinates"))
    if body["kind"] == "reduced":
        coordinates = f"{coordinates} of {body['freedoms']}"
    locks = body.get("locking")
    cells = [*cells, coordinates, "" if locks is None else f"{100 * locks['largest']:.2g} %"]
    held = {"(its frame)": body.get("frequencies in the frame, Hz", ())} | body.get(
        "frequencies held, Hz", {}
    )
    for row, (place, frequencies) in enumerate(held.items()):
        head = cells if row == 0 else [""] * len(cells)
        if len(frequencies) or row == 0:
            yield [*head, place if len(frequencies) else "", _vector(frequencies, digits=4)]


def place_table(numbers: Mapping[str, Any]) -> TextTable:
    """One row per axis of each tracked place; numbers as of `summarize`."""
    rows = []
    for name, place in numbers["tracked"].items():
        for axis, letter in enumerate("xyz"):
            head = [name, place["seen from"]] if axis == 0 else ["", ""]
            values = (place[key][axis] for key in ("largest deflection", "at time", "last deflection"))
            rows.append([*head, letter, *(_number(value) for value in values)])
    heads = ("place", "seen from", "axis", "largest deflection", "at time", "at the end")
    return TextTable("Tracked motion", heads, rows)


def joint_table(numbers: Mapping[str, Any]) -> TextTable:
    """Force and moment on the second end of each joint; numbers as of `summarize`."""
    rows = []
    for name, joint in numbers["joints"].items():
        for row, what in enumerate(what for what in ("force", "moment") if f"largest {what}" in joint):
            largest = (_number(joint[f"{size} {what}"]) for size in ("largest", "time of largest"))
            rows.append([name if row == 0 else "", what, *largest, _vector(joint[f"last {what}"])])
    heads = ("joint", "on its second end", "largest", "at time", "at the end (x, y, z of the joint)")
    return TextTable("Joints", heads, rows)


def correction_table(numbers: Sequence[Mapping[str, Any]]) -> TextTable:
    """One row a round and body; numbers as of `correction_numbers`."""
    rows = []
    for each in numbers:
        errors = (_error(each[key]) for key in ("estimated_error", "allowed", "indicator"))
        rows.append([each["body"], str(each["round"]), str(each["size"]), *errors, f"{each['seconds']:.1f}"])
    heads = ("body", "round", "coordinates", "estimated error", "allowed", "missing motion", "seconds")
    return TextTable("Self-correction", heads, rows)


def cost_line(cost: Statistics) -> str:
    """Steps, iterations and seconds in one line."""
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
