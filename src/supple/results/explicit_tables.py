"""The numbers of an explicit run as tables of words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from supple.results.round_off import without_noise
from supple.results.run_tables import TextTable
from supple.units import headed

__all__ = ["explicit_cost_line", "explicit_tables"]


def explicit_tables(numbers: Mapping[str, Any]) -> list[TextTable]:
    """Parts, energies with their balance, and tracked places if any; numbers as of `summarize_explicit`."""
    tables = [_parts(numbers), _energies(numbers)]
    return [*tables, _tracked(numbers)] if numbers["tracked"] else tables


def _parts(numbers: Mapping[str, Any]) -> TextTable:
    units, rows = numbers["units"], []
    for name, part in numbers["parts"].items():
        if part["kind"] == "modal":
            size, yielded = f"{part['modes']} modes", ""
        else:
            lost = f", {part['deleted']} deleted" if part["deleted"] else ""
            size, yielded = f"{part['elements']} elements{lost}", f"{part['largest plastic strain']:.3g}"
        row = [name, part["kind"], f"{part['mass']:.5g}", str(part["nodes"]), size]
        rows.append([*row, f"{part['step limit']:.4g}", _stress(part.get("largest stress")), yielded])
    heads = (
        *("part", "kind", headed("mass", units.get("mass", "")), "nodes", "size"),
        headed("longest step at rest", units.get("time", "")),
        headed("largest von Mises stress", units.get("stress", "")),
        "largest plastic strain",
    )
    return TextTable("Parts", heads, rows)


def _stress(found: Mapping[str, Any] | None) -> str:
    """The value and the node or the cell that has it."""
    if found is None:
        return ""
    place = "node" if "node" in found else "cell"
    return f"{found['value']:.4g} ({place} {found[place]})"


def _energies(numbers: Mapping[str, Any]) -> TextTable:
    energy, time = (numbers["units"].get(what, "") for what in ("energy", "time"))
    rows = [
        [name, *(f"{held[key]:.5g}" for key in ("start", "largest", "time of largest", "end"))]
        for name, held in numbers["energies"].items()
    ]
    balance = numbers["balance"]
    rows.append(
        ["open in the balance", "", f"{balance['largest']:.2g}", "", f"{balance['relative']:.1e} of all"]
    )
    heads = (
        *("energy", headed("at the start", energy), headed("largest", energy)),
        *(headed("at time", time), headed("at the end", energy)),
    )
    return TextTable("Energies", heads, rows)


def _tracked(numbers: Mapping[str, Any]) -> TextTable:
    length, rows = numbers["units"].get("length", ""), []
    for name, place in numbers["tracked"].items():
        ends = without_noise([place[f"{which} position"] for which in ("lowest", "highest", "last")])
        for axis, letter in enumerate("xyz"):
            rows.append([name if axis == 0 else "", letter, *(f"{end:.5g}" for end in ends[:, axis])])
    heads = (
        "place",
        "global axis",
        *(headed(which, length) for which in ("lowest", "highest", "at the end")),
    )
    return TextTable("Tracked motion", heads, rows)


def explicit_cost_line(numbers: Mapping[str, Any]) -> str:
    """Steps and seconds in one line."""
    steps, cost = numbers["steps"], numbers["statistics"]
    time = numbers["units"].get("time", "")
    longest = f"{steps['largest']:.3g}{f' {time}' if time else ''}"
    return (
        f"{cost['steps']} explicit steps of at most {longest}, up to {steps['largest ratio']} in one of the "
        f"modal parts; {cost['seconds']:.2f} s with compilation"
    )
