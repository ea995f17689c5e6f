"""Tables of the results of a run: bodies, tracked motion, joints, rounds of self-correction."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from supple.integrate import PARTS, Statistics
from supple.quantities.reading import point_words
from supple.results.round_off import without_noise
from supple.units import UNNAMED, UnitSystem, headed

Numbers = Mapping[str, Any]
"""Results under the names of a JSON report."""


class TextTable(NamedTuple):
    """A table of plain text, without markup."""

    title: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]


def head(numbers: Numbers, name: str, quantity: str) -> str:
    """Head of a column, with the unit of a quantity if it has a name."""
    return headed(name, numbers["units"].get(quantity, ""))


def motion_tables(numbers: Numbers) -> list[TextTable]:
    """Tables of bodies, and of joints, contacts, places, stress, sensors and energies, if any.

    numbers : from `summarize`, with those of `stress_numbers` and of sensors
    """
    tables = [body_table, joint_table, contact_table, motion_table, place_table, stress_table, sensor_table]
    if numbers.get("energies"):
        tables += [part_table, energy_table]
    return [table for of_numbers in tables if (table := of_numbers(numbers)).rows]


def stress_table(numbers: Numbers) -> TextTable:
    """The largest stress of each body; numbers from `stress_numbers`."""
    rows = [
        [
            name
            + (f" (without {each['cells without stress']} cells)" if "cells without stress" in each else ""),
            _number(each["largest von Mises stress"]),
            str(each["node"]) if "node" in each else f"in cell {each['cell']}",
            _vector(each["point"], digits=4),
            _number(each["time"]),
        ]
        for name, each in numbers.get("stress", {}).items()
    ]
    place, time = head(numbers, "x, y, z of the undeformed node", "length"), head(numbers, "at time", "time")
    heads = ("body", head(numbers, "largest von Mises stress", "stress"), "at node", place, time)
    return TextTable("Stress", heads, rows)


def part_table(numbers: Numbers) -> TextTable:
    """Step limits, plastic strain and deleted elements of explicit parts; numbers from `summarize`."""
    rows = []
    for name, part in ((name, part) for name, part in numbers["bodies"].items() if "step limit" in part):
        lost = f", {part['deleted']} deleted" if part.get("deleted") else ""
        size = f"{part['elements']} elements{lost}" if "elements" in part else f"{part['coordinates']} modes"
        yielded = f"{part['largest plastic strain']:.3g}" if "largest plastic strain" in part else ""
        rows.append([name, size, f"{part['step limit']:.4g}", yielded])
    longest = head(numbers, "step limit at rest", "time")
    return TextTable("Parts", ("body", "size", longest, "largest plastic strain"), rows)


def energy_table(numbers: Numbers) -> TextTable:
    """The energies of an explicit run, and their balance error; numbers from `summarize`."""
    rows = [
        [name, *(f"{held[key]:.5g}" for key in ("start", "largest", "time of largest", "end"))]
        for name, held in numbers["energies"].items()
    ]
    balance = numbers["balance"]
    rows.append(["balance error", "", f"{balance['largest']:.2g}", "", f"{balance['relative']:.1e} relative"])
    start, largest = head(numbers, "at the start", "energy"), head(numbers, "largest", "energy")
    time, last = head(numbers, "time of largest", "time"), head(numbers, "at the end", "energy")
    heads = ("energy", start, largest, time, last)
    return TextTable("Energies", heads, rows)


def sensor_table(numbers: Numbers, *, at_rest: bool = False) -> TextTable:
    """Smallest, largest and last value of each channel of each sensor; numbers from `Reading.plain`.

    For sensors at nodes, a last column gives the node of the largest magnitude.
    at_rest : give the last value only
    """
    sensors, extremes = numbers.get("sensors", {}), () if at_rest else ("smallest", "largest")
    located = any("place" in reading for each in sensors.values() for reading in each.values())
    rows = []
    for name, channels in sensors.items():
        for row, (channel, reading) in enumerate(channels.items()):
            alike = [each for each in channels.values() if each["quantity"] == reading["quantity"]]
            scale = [each[extreme] for each in alike for extreme in ("smallest", "largest")]
            cells = [name if row == 0 else "", headed(channel, reading["unit"])]
            for extreme in extremes:
                value = float(without_noise(reading[extreme], like=scale))
                cells += [_number(value), _number(reading[f"time of {extreme}"] if value else 0.0)]
            where = [place_words(reading)] if located else []
            rows.append([*cells, _number(float(without_noise(reading["last"], like=scale))), *where])
    time = head(numbers, "at time", "time")
    values = ("value",) if at_rest else ("smallest", time, "largest", time, "at the end")
    place = ("where" if at_rest else "where the magnitude is largest",) if located else ()
    return TextTable("Sensors", ("sensor", "channel", *values, *place), rows)


def place_words(reading: Numbers) -> str:
    """The node at which a channel has its largest magnitude, and the place of the sensor."""
    extreme = "smallest" if abs(reading["smallest"]) > abs(reading["largest"]) else "largest"
    words = reading.get("place", "")
    if f"node of {extreme}" not in reading or "node " in words:
        return words
    node, point = reading[f"node of {extreme}"], reading[f"point of {extreme}"]
    return f"{point_words(node, point)}, {words}"


def body_table(numbers: Numbers) -> TextTable:
    """Size and lowest frequencies, one row per body and support; numbers from `summarize`."""
    hertz = numbers["units"].get("frequency", "")
    heads = (
        *("body", "kind", head(numbers, "mass", "mass"), "nodes", "DOF", "locking", "fixed at"),
        headed("lowest frequencies", hertz),
    )
    rows = [row for name, body in numbers["bodies"].items() for row in _body_rows(name, body, hertz)]
    if any("damping ratios held" in body for body in numbers["bodies"].values()):
        return TextTable("Bodies", (*heads, "damping ratios, %"), rows)
    return TextTable("Bodies", heads, [row[:-1] for row in rows])


def _body_rows(name: str, body: Numbers, hertz: str) -> Iterable[list[str]]:
    cells = [name, body["kind"], _number(body.get("mass")), _count(body.get("nodes"))]
    coordinates = _count(body.get("coordinates"))
    if body["kind"] == "reduced":
        coordinates = f"{coordinates} of {body['freedoms']}"
    locks = body.get("locking")
    cells = [*cells, coordinates, "" if locks is None else f"{100 * locks['largest']:.2g} %"]
    held = {"floating frame": body.get(headed("frequencies in the frame", hertz), ())}
    held |= body.get(headed("frequencies held", hertz), {})
    damped = body.get("damping ratios held", {})
    of_basis = ", basis" if body.get("frequencies of") == "the basis" else ""
    found = {place + of_basis: (place, each) for place, each in held.items() if len(each)}
    for row, (shown, (place, frequencies)) in enumerate((found or {"": ("", ())}).items()):
        first = cells if row == 0 else [""] * len(cells)
        ratios = _vector([100 * ratio for ratio in damped.get(place, ())], digits=3)
        yield [*first, shown, _vector(frequencies, digits=4), ratios]


def motion_table(numbers: Numbers) -> TextTable:
    """Range of each tracked place, one row per global axis; numbers from `summarize`."""
    rows = []
    for name, place in numbers["tracked"].items():
        ends = [place[f"{which} position"] for which in ("lowest", "highest", "last")]
        rows += by_axis([name], *without_noise(ends))
    values = (head(numbers, which, "length") for which in ("lowest", "highest", "at the end"))
    return TextTable("Tracked motion", ("place", "global axis", *values), rows)


def place_table(numbers: Numbers) -> TextTable:
    """Deflection of each tracked place of an elastic body, one row per axis; numbers from `summarize`."""
    rows = []
    for name, place in numbers["tracked"].items():
        moved = [place[f"{which} position"] for which in ("lowest", "highest")]
        largest, last = (
            without_noise(place[f"{which} deflection"], like=moved) for which in ("largest", "last")
        )
        if place["elastic"]:
            when = np.where(largest, place["at time"], 0.0)
            rows += by_axis([name, place["seen from"]], largest, when, last)
    time, last = head(numbers, "time of largest", "time"), head(numbers, "at the end", "length")
    heads = ("place", "seen from", "axis", head(numbers, "largest deflection", "length"), time, last)
    return TextTable("Deflection", heads, rows)


def by_axis(first: Sequence[str], *values: Sequence[float | None] | np.ndarray) -> list[list[str]]:
    """A row for each of x, y, z; only the first row has the cells of `first`."""
    return [
        [*(first if axis == 0 else [""] * len(first)), letter, *(_number(each[axis]) for each in values)]
        for axis, letter in enumerate("xyz")
    ]


def joint_table(numbers: Numbers) -> TextTable:
    """Force and moment on the second end of each joint; numbers from `summarize`."""
    rows, scales = [], load_scales(numbers)
    for name, joint in numbers["joints"].items():
        for row, what in enumerate(what for what in ("force", "moment") if f"largest {what}" in joint):
            first = [name, joint["acts on"]] if row == 0 else ["", ""]
            largest = float(without_noise(joint[f"largest {what}"], like=scales[what]))
            when = joint[f"time of largest {what}"] if largest else 0.0
            last = _vector(without_noise(joint[f"last {what}"], like=scales[what]))
            rows.append([*first, head(numbers, what, what), _number(largest), _number(when), last])
    time = head(numbers, "time of largest", "time")
    heads = ("joint", "acts on", "load", "largest magnitude", time, "at the end: x, y, z of the joint")
    return TextTable("Joints", heads, rows)


def load_scales(numbers: Numbers) -> dict[str, list[float]]:
    """The largest force, and moment, of each joint."""
    return {
        what: [joint.get(f"largest {what}", 0.0) for joint in numbers["joints"].values()]
        for what in ("force", "moment")
    }


def contact_table(numbers: Numbers) -> TextTable:
    """Largest force of each contact on its nodes, at the output times; numbers from `summarize`."""
    rows = []
    for name, contact in numbers.get("contacts", {}).items():
        largest, components = contact["largest force"], contact["components of largest force"]
        when = contact["time of largest force"] if largest else 0.0
        words = _vector(without_noise(components, like=[largest]))
        rows.append([name.removeprefix("contact of "), _number(largest), _number(when), words])
    largest, time = head(numbers, "largest force on the nodes", "force"), head(numbers, "at time", "time")
    heads = ("contact of", largest, time, head(numbers, "x, y, z of that force", "force"))
    return TextTable("Contacts", heads, rows)


def correction_table(numbers: Sequence[Numbers], units: UnitSystem = UNNAMED) -> TextTable:
    """One row per round and body; numbers from `correction_numbers`, lengths in the given units."""
    rows = []
    for each in numbers:
        errors = (shown_error(each[key]) for key in ("estimated_error", "allowed", "indicator"))
        seen = ", ".join(word for word in ("useless", "unconfirmed") if each.get(word))
        rows.append(
            [each["body"], str(each["round"]), str(each["size"]), *errors, f"{each['seconds']:.1f}", seen]
        )
    lengths = (headed(what, units.length) for what in ("estimated error", "allowed", "missing motion"))
    heads = ("body", "round", "coordinates", *lengths, "seconds", "")
    return TextTable("Self-correction", heads, rows)


def error_table(numbers: Numbers) -> TextTable:
    """The parts of the error and their sum, one row per quantity; numbers from `summarize`."""
    rows = []
    for name, stated in numbers["errors"].items():
        parts = [
            shown_error(stated["parts"][part]["value"]) if part in stated["parts"] else "not estimated"
            for part in PARTS
        ]
        total = shown_error(stated["at_least"])
        at_least = "" if len(stated["parts"]) == len(PARTS) else "at least "
        allowed = "" if stated["allowed"] is None else shown_error(stated["allowed"])
        of = head(numbers, name, stated.get("quantity", ""))
        rows.append([of, *parts, f"{at_least}{total}", allowed, shown_error(stated["size"])])
    heads = ("error of", "basis", "step", "Newton", "model", "sum", "allowed", "reference size")
    return TextTable("Error", heads, rows)


def error_lines(numbers: Numbers) -> list[str]:
    """Description of each row of the error table, remedy for its largest part, and errors not included."""
    lines = [
        f"{name}: {stated['of']}" + (f"; {stated['advice']}" if stated["advice"] else "")
        for name, stated in numbers["errors"].items()
    ]
    return [*lines, "The errors of mesh, material and loads are not included"] if lines else []


def cost_line(cost: Statistics) -> str:
    """Steps, iterations and seconds in one line."""
    tangents = ""
    if cost.factorizations and cost.contraction is not None:
        left = f"{cost.contraction:.2g} of the residual"
        tangents = f", {cost.factorizations} factorizations, an iteration leaves {left}"
    return (
        f"{cost.steps} steps, {cost.iterations} Newton iterations{tangents}, {cost.rejected_steps} cuts; "
        f"{cost.seconds:.2f} s of simulation after {cost.compile_seconds:.1f} s of compilation"
    )


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"


def _count(value: int | None) -> str:
    return "" if value is None else str(value)


def _vector(values: Sequence[float] | np.ndarray, digits: int = 5) -> str:
    return "  ".join(f"{value:.{digits}g}" for value in values)


def shown_error(value: float | None) -> str:
    """An error as text."""
    return "unknown" if value is None else f"{value:.2e}"
