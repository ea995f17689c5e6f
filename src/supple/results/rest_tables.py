"""Tables of an equilibrium and of its basis error."""

from __future__ import annotations

from supple.results.round_off import without_noise
from supple.results.run_tables import (
    Numbers,
    TextTable,
    body_table,
    by_axis,
    head,
    load_scales,
    sensor_table,
    shown_error,
)


def rest_tables(numbers: Numbers) -> list[TextTable]:
    """Tables of bodies, joint forces, positions, deflections and sensors; numbers from `summarize`."""
    tables = [_joint_table(numbers), *_place_tables(numbers), sensor_table(numbers, at_rest=True)]
    return [body_table(numbers), *(table for table in tables if table.rows)]


def _joint_table(numbers: Numbers) -> TextTable:
    """Force and moment on the second end of each joint, along the axes of the joint."""
    rows, scales = [], load_scales(numbers)
    for name, joint in numbers["joints"].items():
        shown = [
            without_noise(joint[f"last {what}"], like=scales[what]) if f"last {what}" in joint else [None] * 3
            for what in ("force", "moment")
        ]
        rows += by_axis([name, joint["acts on"]], *shown)
    heads = ("joint", "acts on", "axis of the joint", *(head(numbers, what, what) for what in scales))
    return TextTable("Joints", heads, rows)


def _place_tables(numbers: Numbers) -> list[TextTable]:
    """Positions of tracked places in global axes, and deflections of places on elastic bodies.

    A column gives the basis error if it is known for any place.
    """
    places = numbers["tracked"]
    everywhere = [place["last position"] for place in places.values()]
    tables = []
    for what, axis in (("position", "global axis"), ("deflection", "axis")):
        of_deflection = what == "deflection"
        shown = {name: place for name, place in places.items() if place["elastic"] or not of_deflection}
        errors = {name: place.get(f"error of {what}") for name, place in shown.items()}
        is_known = any(error is not None for error in errors.values())
        heads = ["place", *(["seen from"] if of_deflection else []), axis, head(numbers, what, "length")]
        rows = []
        for name, place in shown.items():
            own = by_axis(
                [name, place["seen from"]] if of_deflection else [name],
                without_noise(place[f"last {what}"], like=everywhere),
            )
            if is_known:
                error = errors[name]
                known = () if error is None else without_noise(error, like=everywhere)
                words = [f"{each:.2g}" for each in known] or ["unknown"] * 3
                own = [[*row, word] for row, word in zip(own, words, strict=True)]
            rows += own
        if is_known:
            heads.append(head(numbers, "error of the basis", "length"))
        tables.append(TextTable(f"{what.capitalize()}s", tuple(heads), rows))
    return tables


def rest_error_table(numbers: Numbers) -> TextTable:
    """Basis error of each reduced body at rest; `numbers["errors"]` from `EquilibriumError.plain`."""
    rows = [
        [
            name,
            shown_error(error["rms"]),
            shown_error(error["worst"]),
            shown_error(error["largest displacement"]),
            _percent(error["relative"]),
            _percent(error["strain"]),
            shown_error(error["second sweep"]),
        ]
        for name, error in numbers["errors"].items()
    ]
    heads = (
        *("error of", head(numbers, "RMS over nodes", "length"), head(numbers, "worst node", "length")),
        *(head(numbers, "of displacements up to", "length"), "worst, %", "strain, %", "second sweep / first"),
    )
    return TextTable("Error of the basis at rest", heads, rows)


def _percent(value: float | None) -> str:
    return "unknown" if value is None else f"{100 * value:.2g}"
