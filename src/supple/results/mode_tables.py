"""Tables of modes, and of their frequencies over speed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from supple.linearization import CampbellDiagram
from supple.linearization.linear_machine import STANDING
from supple.results.run_tables import TextTable
from supple.units import UnitSystem, headed, plain_number

__all__ = ["SENSES", "mode_table", "speed_tables"]

SENSES = {1: "forward", -1: "backward", 0: ""}
"""Names of the senses of whirl."""


def speed_tables(diagram: CampbellDiagram, units: UnitSystem) -> Iterator[TextTable]:
    """Tables of frequencies over speed and, if there are any, of whirl frequencies and critical speeds."""
    unit, factor = units.frequency_shown
    shown, by_rate = units.rotation_shown
    speeds = [plain_number(by_rate * rate, 5) for rate in diagram.rates]

    def table(title: str, values: np.ndarray) -> TextTable:
        heads = [headed("speed", shown), *(headed(name, unit) for name in diagram.names)]
        cells = factor * values / (2 * np.pi)
        rows = [[speed, *map(_frequency, row)] for speed, row in zip(speeds, cells, strict=True)]
        return TextTable(title, heads, rows)

    title, heads, rows = table(f"Frequencies over speed, in axes {diagram.axes}", diagram.frequencies)
    if diagram.errors is not None:
        heads = [*heads, "largest error, %"]
        rows = [[*row, _largest_error(off)] for row, off in zip(rows, diagram.errors, strict=True)]
    yield TextTable(title, heads, rows)
    if np.any(diagram.sense) and diagram.axes != STANDING:
        yield table("Whirl in space", diagram.in_space)
    if critical := diagram.critical_speeds:
        found = [[plain_number(by_rate * each.rate, 5), SENSES[each.sense]] for each in critical]
        yield TextTable("Critical speeds", [headed("speed", shown), "whirl"], found)


def _frequency(value: float) -> str:
    return plain_number(value, 5) if np.isfinite(value) else ""


def mode_table(numbers: Mapping[str, Any]) -> TextTable:
    """Modes with their motion, frequency, error and damping; numbers from `supple modes`."""
    unit = numbers["units"].get("frequency", "")
    turns = numbers["axes"] != STANDING
    whirls = any(mode["frequency in space"] is not None for mode in numbers["modes"])
    rows = []
    for number, mode in enumerate(numbers["modes"], start=1):
        body, share = max(mode["kinetic_share"].items(), key=lambda item: item[1])
        space = mode["frequency in space"]
        whirl = [mode["whirl"]] if whirls else []
        whirl += ["" if space is None else _frequency(space)] if whirls and turns else []
        rows.append(
            [
                str(number),
                mode["name"],
                _frequency(mode["frequency"]),
                *whirl,
                _error(mode),
                f"{100 * mode['damping_ratio']:.3g}",
                f"{body} ({100 * share:.0f} %)",
                "unstable" if mode["unstable"] else "",
            ]
        )
    whirl = ["whirl", headed("in space", unit)][: 1 + turns] if whirls else []
    heads = ["mode", "motion", headed("frequency", unit), *whirl, "error, %", "damping, %"]
    floquet = " (Floquet modes of periodic equations)" if numbers["periodic"] else ""
    title = f"Modes of the machine, in axes {numbers['axes']}{floquet}"
    return TextTable(title, [*heads, "largest share of kinetic energy", "stability"], rows)


def _error(mode: dict[str, Any]) -> str:
    """Error of a frequency, in percent."""
    if mode["none of the machine's"]:
        return "no such mode"
    return "unknown" if mode["error"] is None else _percent(mode["error"])


def _largest_error(errors: np.ndarray) -> str:
    """Largest error of the frequencies at one speed, in percent, and its mode."""
    if np.isnan(errors).all():
        return "unknown"
    worst = int(np.nanargmax(errors))
    shown = _percent(errors[worst]) if np.isfinite(errors[worst]) else "no such mode"
    return f"{shown} (mode {worst + 1})"


def _percent(error: float) -> str:
    return "< 0.01" if 100 * error < 0.01 else f"{100 * error:.2g}"
