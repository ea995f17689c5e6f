"""Tables of an equilibrium and of its basis error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from supple.results.round_off import without_noise
from supple.results.run_tables import TextTable, body_table, place_words
from supple.units import headed

__all__ = ["rest_error_table", "rest_tables"]


def rest_tables(numbers: Mapping[str, Any]) -> list[TextTable]:
    """Tables of bodies, joint forces, positions, deflections and sensors; numbers from `summarize`."""
    tables = [_joint_table(numbers), *_place_tables(numbers), _sensor_table(numbers)]
    return [body_table(numbers), *(table for table in tables if table.rows)]


def _joint_table(numbers: Mapping[str, Any]) -> TextTable:
    """Force and moment on the second end of each joint, along the axes of the joint."""
    joints, units = numbers["joints"], numbers["units"]
    scales = {
        what: [joint.get(f"largest {what}", 0.0) for joint in joints.values()] for what in ("force", "moment")
    }
    rows = []
    for name, joint in joints.items():
        shown = [
            without_noise(joint[f"last {what}"], like=scales[what]) if f"last {what}" in joint else [None] * 3
            for what in ("force", "moment")
        ]
        rows += _by_axis([name, joint["acts on"]], *shown)
    heads = ("joint", "acts on", "axis of the joint", *(headed(what, units.get(what, "")) for what in scales))
    return TextTable("Joints", heads, rows)


def _sensor_table(numbers: Mapping[str, Any]) -> TextTable:
    """The value of each channel of each sensor, with its place if any sensor has one."""
    sensors = numbers.get("sensors", {})
    located = any("place" in reading for each in sensors.values() for reading in each.values())
    rows = []
    for name, channels in sensors.items():
        for row, (channel, reading) in enumerate(channels.items()):
            alike = [each["last"] for each in channels.values() if each["quantity"] == reading["quantity"]]
            value = float(without_noise(reading["last"], like=alike))
            where = [place_words(reading)] if located else []
            rows.append([name if row == 0 else "", headed(channel, reading["unit"]), f"{value:.5g}", *where])
    return TextTable("Sensors", ("sensor", "channel", "value", *(["where"] if located else [])), rows)


def _place_tables(numbers: Mapping[str, Any]) -> list[TextTable]:
    """Positions of tracked places in global axes, and deflections of places on elastic bodies.

    A column gives the basis error if it is known for any place.
    """
    length, places = numbers["units"].get("length", ""), numbers["tracked"]
    everywhere = [place["last position"] for place in places.values()]
    tables = []
    for what, axis in (("position", "global axis"), ("deflection", "axis")):
        of_deflection = what == "deflection"
        shown = {name: place for name, place in places.items() if place["elastic"] or not of_deflection}
        errors = {name: place.get(f"error of {what}") for name, place in shown.items()}
        is_known = any(error is not None for error in errors.values())
        heads = ["place", *(["seen from"] if of_deflection else []), axis, headed(what, length)]
        rows = []
        for name, place in shown.items():
            own = _by_axis(
                [name, place["seen from"]] if of_deflection else [name],
                without_noise(place[f"last {what}"], like=everywhere),
            )
            if is_known:
                words = _error_words(errors[name], like=everywhere)
                own = [[*row, word] for row, word in zip(own, words, strict=True)]
            rows += own
        if is_known:
            heads.append(headed("error of the basis", length))
        tables.append(TextTable(f"{what.capitalize()}s", tuple(heads), rows))
    return tables


def _error_words(error: Sequence[float] | None, like: Sequence[Any]) -> list[str]:
    """The error along x, y and z; zero where it is round-off relative to the positions of all places."""
    return ["unknown"] * 3 if error is None else [f"{each:.2g}" for each in without_noise(error, like=like)]


def _by_axis(head: Sequence[str], *values: Any) -> list[list[str]]:
    """A row for each of x, y, z; only the first row has the cells of `head`."""
    return [
        [
            *(head if axis == 0 else [""] * len(head)),
            letter,
            *("" if each[axis] is None else f"{each[axis]:.5g}" for each in values),
        ]
        for axis, letter in enumerate("xyz")
    ]


def rest_error_table(numbers: Mapping[str, Any]) -> TextTable:
    """Basis error of each reduced body at rest; `numbers["errors"]` from `EquilibriumError.plain`."""
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
        *(headed("of displacements up to", length), "worst, %", "strain, %", "second sweep / first"),
    )
    return TextTable("Error of the basis at rest", heads, rows)


def _number(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.2e}"


def _percent(value: float | None) -> str:
    return "unknown" if value is None else f"{100 * value:.2g}"
