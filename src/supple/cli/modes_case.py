"""Find the modes of the machine of a case file, and list them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from supple import cases
from supple.errors import CaseError
from supple.terminal import Steps, print_table, progress_bars, say
from supple.units import headed


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
        unit, factor = case.units.frequency_shown
        frequencies = factor * diagram.frequencies / (2 * np.pi)
        heads = [
            "rad per unit of time",
            *(headed(f"mode {i + 1}", unit) for i in range(frequencies.shape[1])),
        ]
        rows = [
            [f"{rate:.5g}", *(f"{each:.5g}" for each in row)]
            for rate, row in zip(diagram.rates, frequencies, strict=True)
        ]
        if diagram.errors is not None:
            heads.append("largest error, %")
            for row, off in zip(rows, diagram.errors, strict=True):
                row.append(_largest_error(off))
        print_table("Frequencies over speed, in axes that turn with the machine", heads, rows)
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


def _mode_table(numbers: dict[str, Any]) -> tuple[str, list[str], list[list[str]]]:
    unit = numbers["units"].get("frequency", "")
    rows = []
    for number, mode in enumerate(numbers["modes"], start=1):
        body, share = max(mode["kinetic_share"].items(), key=lambda item: item[1])
        rows.append(
            [
                str(number),
                f"{mode['frequency']:.5g}",
                _error(mode),
                f"{100 * mode['damping_ratio']:.3g}",
                f"{body} ({100 * share:.0f} %)",
                "unstable" if mode["unstable"] else "",
            ]
        )
    heads = ["mode", headed("frequency", unit), "error, %", "damping, %", "moves most", "stability"]
    return f"Modes of the machine, in axes {numbers['axes']}", heads, rows


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
