"""Find the modes of the machine of a case file, and list them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from supple import cases
from supple.cases.modes_case import SENSES
from supple.errors import CaseError
from supple.linearization import CampbellDiagram
from supple.linearization.linear_machine import STANDING
from supple.terminal import Steps, print_table, progress_bars, say
from supple.units import UnitSystem, headed, plain_number

_Table = tuple[str, list[str], list[list[str]]]


def modes_case(
    path: Path, folder: Path, *, n_modes: int, time: float, rates: str | None, errors: bool, allow_code: bool
) -> None:
    """Print the modes of the case at `path`, or its frequencies over speed.

    rates : "FROM:TO:NUMBER" of a Campbell diagram, rad per unit of time; modes at the case's own when None
    Errors as for `cases.modes_case` and `cases.campbell_case`.
    """
    speeds = None if rates is None else _speeds(rates)
    bars = progress_bars()
    steps = Steps(bars)
    case = cases.read_case(path, steps.show)
    say(case.title, "bold")
    if speeds is None:
        with bars:
            _, numbers = cases.modes_case(
                case,
                folder,
                n_modes=n_modes,
                time=time,
                errors=errors,
                allow_code=allow_code,
                progress=steps.share,
            )
            steps.finish()
        print_table(*_mode_table(numbers))
    else:
        with bars:
            diagram = cases.campbell_case(
                case,
                folder,
                speeds.tolist(),
                n_modes=n_modes,
                errors=errors,
                allow_code=allow_code,
                progress=steps.share,
            )
            steps.finish()
        for table in _speed_tables(diagram, case.units):
            print_table(*table)
    say(f"Results are in {folder}/")


def _speeds(text: str) -> np.ndarray:
    try:
        first, last, number = text.split(":")
        if not 2 <= int(number) <= 10_000:
            raise ValueError
        return np.linspace(float(first), float(last), int(number))
    except ValueError as error:
        raise CaseError(
            f"--rates '{text}' is not FROM:TO:NUMBER, such as 0:2:9 (two speeds or more)"
        ) from error


def _speed_tables(diagram: CampbellDiagram, units: UnitSystem) -> Iterator[_Table]:
    """Frequencies over speed, those of whirls in space, and critical speeds, as far as there are any."""
    unit, factor = units.frequency_shown
    shown, by_rate = units.rotation_shown
    speeds = [plain_number(by_rate * rate, 5) for rate in diagram.rates]

    def table(title: str, values: np.ndarray) -> _Table:
        heads = [headed("speed", shown), *(headed(name, unit) for name in diagram.names)]
        cells = factor * values / (2 * np.pi)
        rows = [[speed, *map(_frequency, row)] for speed, row in zip(speeds, cells, strict=True)]
        return title, heads, rows

    title, heads, rows = table(f"Frequencies over speed, in axes {diagram.axes}", diagram.frequencies)
    if diagram.errors is not None:
        heads.append("largest error, %")
        for row, off in zip(rows, diagram.errors, strict=True):
            row.append(_largest_error(off))
    yield title, heads, rows
    if np.any(diagram.sense) and diagram.axes != STANDING:
        yield table("Whirl in space", diagram.in_space)
    if critical := diagram.critical_speeds:
        found = [[plain_number(by_rate * each.rate, 5), SENSES[each.sense]] for each in critical]
        yield "Critical speeds", [headed("speed", shown), "whirl"], found


def _frequency(value: float) -> str:
    return plain_number(value, 5) if np.isfinite(value) else ""


def _mode_table(numbers: dict[str, Any]) -> _Table:
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
    floquet = " (Floquet's modes, of equations that change as it turns)" if numbers["periodic"] else ""
    title = f"Modes of the machine, in axes {numbers['axes']}{floquet}"
    return title, [*heads, "moves most", "stability"], rows


def _error(mode: dict[str, Any]) -> str:
    """Of a frequency, in percent."""
    if mode["none of the machine's"]:
        return "no such mode"
    return "unknown" if mode["error"] is None else _percent(mode["error"])


def _largest_error(errors: np.ndarray) -> str:
    """Of the frequencies at one speed, in percent, and of which mode."""
    if np.isnan(errors).all():
        return "unknown"
    worst = int(np.nanargmax(errors))
    shown = _percent(errors[worst]) if np.isfinite(errors[worst]) else "no such mode"
    return f"{shown} (mode {worst + 1})"


def _percent(error: float) -> str:
    return "< 0.01" if 100 * error < 0.01 else f"{100 * error:.2g}"
