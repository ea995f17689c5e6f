"""Tables of modes, and of their frequencies over speed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from supple.linearization import CampbellDiagram
from supple.linearization.linear_machine import STANDING
from supple.results.run_tables import Numbers, TextTable, head
from supple.units import UnitSystem, headed, plain_number, with_unit

_HELD = 1e-3
"""Least share of the mass that moves with a mode of a machine held by the ground."""

SENSES = {1: "forward", -1: "backward", 0: ""}
"""Names of the senses of whirl."""

_NO_DAMPING = 1e-9
"""Damping ratio up to which a table shows zero."""


def speed_tables(diagram: CampbellDiagram, units: UnitSystem) -> Iterator[TextTable]:
    """Tables of frequencies over speed and, if there are any, of whirls, damping, critical speeds, onsets."""
    unit, factor = units.frequency_shown
    shown, by_rate = units.rotation_shown
    speeds = [plain_number(by_rate * rate, 5) for rate in diagram.rates]

    def table(title: str, values: np.ndarray, unit: str) -> TextTable:
        heads = [headed("speed", shown), *(headed(name, unit) for name in diagram.names)]
        rows = [[speed, *map(_frequency, row)] for speed, row in zip(speeds, values, strict=True)]
        return TextTable(title, heads, rows)

    hertz = factor / (2 * np.pi)
    frequencies = hertz * diagram.frequencies
    title, heads, rows = table(f"Frequencies over speed, in axes {diagram.axes}", frequencies, unit)
    if diagram.errors is not None:
        heads = [*heads, "largest error, %"]
        rows = [[*row, _largest_error(off)] for row, off in zip(rows, diagram.errors, strict=True)]
    yield TextTable(title, heads, rows)
    whirls = bool(np.any(diagram.sense)) and diagram.axes != STANDING
    if whirls:
        yield table("Whirl in space", hertz * diagram.in_space, unit)
    damping = diagram.observed_damping_ratios
    if np.any(abs(np.nan_to_num(damping)) > _NO_DAMPING):
        yield table(f"Damping over speed{', of whirls in space' * whirls}", _percents(damping), "%")
    if critical := diagram.critical_speeds:
        found = [[plain_number(by_rate * each.rate, 5), SENSES[each.sense]] for each in critical]
        yield TextTable("Critical speeds", [headed("speed", shown), "whirl"], found)
    if onsets := diagram.onsets:
        found = [[plain_number(by_rate * each.rate, 5), diagram.names[each.mode]] for each in onsets]
        yield TextTable("Onset of instability", [headed("speed", shown), "mode"], found)


def _percents(ratios: np.ndarray) -> np.ndarray:
    """Damping ratios in percent, without rounding errors of motions that are not damped."""
    return 100 * np.where(abs(ratios) <= _NO_DAMPING, 0.0, ratios)


def _frequency(value: float) -> str:
    return plain_number(value, 5) if np.isfinite(value) else ""


def mode_tables(numbers: Numbers) -> list[TextTable]:
    """Modes, and their effective masses if the ground holds the machine; numbers from `supple modes`."""
    return [_mode_table(numbers), *_effective_mass_tables(numbers)]


def _mode_table(numbers: Numbers) -> TextTable:
    """Modes with their motion, frequency, error and damping; numbers from `supple modes`."""
    turns = numbers["axes"] != STANDING
    whirls = any(mode["frequency in space"] is not None for mode in numbers["modes"])
    rows = []
    for number, mode in enumerate(numbers["modes"], start=1):
        body, share = max(mode["kinetic_share"].items(), key=lambda item: item[1])
        space = mode["frequency in space"]
        whirl = [mode["whirl"]] if whirls else []
        if whirls and turns:
            whirl += ["", ""] if space is None else [_frequency(space), _damping(mode["damping in space"])]
        rows.append(
            [
                str(number),
                mode["name"],
                _frequency(mode["frequency"]),
                *whirl,
                *([_error(mode)] if numbers["bodies with a basis"] else []),
                _damping(mode["damping_ratio"]),
                f"{body} ({100 * share:.0f} %)",
                "unstable" if mode["unstable"] else "",
            ]
        )
    whirl = ["whirl"] if whirls else []
    whirl += [head(numbers, "in space", "frequency"), "damping in space, %"] if whirls and turns else []
    error = ["error, %"] if numbers["bodies with a basis"] else []
    heads = ["mode", "motion", head(numbers, "frequency", "frequency"), *whirl, *error, "damping, %"]
    floquet = " (Floquet modes of periodic equations)" if numbers["periodic"] else ""
    title = f"Modes of the machine, in axes {numbers['axes']}{floquet}"
    return TextTable(title, [*heads, "largest share of kinetic energy", "stability"], rows)


def _effective_mass_tables(numbers: Numbers) -> Iterator[TextTable]:
    """Effective masses of the modes of a machine held by the ground; none for other machines."""
    modes, mass = numbers["modes"], numbers["mass"]
    if any(mode["effective_mass"] is None for mode in modes):
        return
    masses = np.array([mode["effective_mass"][:3] for mode in modes])
    moving = np.array([mode["frequency"] > 0 for mode in modes])
    if not (masses[moving] > _HELD * mass).any():
        return
    unit = numbers["units"].get("mass", "")
    cells = np.where(masses > _HELD * 1e-3 * mass, masses, 0.0)
    rows = [
        [str(number), _frequency(mode["frequency"]), *(plain_number(each, 5) for each in own)]
        for number, (mode, own) in enumerate(zip(modes, cells, strict=True), start=1)
    ]
    total = cells.sum(axis=0)
    rows.append(["all", "", *(f"{each:.5g} ({100 * each / mass:.1f} %)" for each in total)])
    heads = ["mode", head(numbers, "frequency", "frequency"), *(headed(axis, unit) for axis in "xyz")]
    yield TextTable(f"Effective masses, of {with_unit(f'{mass:.6g}', unit)}", heads, rows)


def _damping(ratio: float) -> str:
    return f"{float(_percents(np.array(ratio))):.3g}"


def _error(mode: Numbers) -> str:
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
