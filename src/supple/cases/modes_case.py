"""The modes of the machine of a case, about its equilibrium."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from supple.cases.case import Case
from supple.cases.implausible_units import warn_of_units
from supple.cases.notify import Progress, silent
from supple.cases.static_case import check_fixed_sizes, looked_at, spin_of
from supple.errors import CaseError
from supple.linearization import (
    CampbellDiagram,
    MachineModes,
    campbell_diagram,
    linearize,
    machine_modes,
    mode_motion,
)
from supple.machine import Spin
from supple.multibody.equations.build_model import system_length
from supple.results.run_summary import unit_names
from supple.storage import write_json
from supple.storage.file_errors import file_errors

__all__ = ["campbell_case", "modes_case"]

AMPLITUDE = 0.1
"""Of a drawn mode, as a share of the machine's size."""


def modes_case(
    case: Case,
    folder: Path,
    *,
    n_modes: int = 6,
    time: float = 0.0,
    allow_code: bool = False,
    progress: Progress = silent,
) -> tuple[MachineModes, dict[str, Any]]:
    """Modes of a case's machine; writes `CASE-modes.json`, and pictures and animations of the shapes.

    allow_code : whether the controllers that the case names, a program, act

    Raises
    ------
    CaseError           a body whose size only a run can tell
    ModelError          whatever `linearize` refuses
    ConvergenceError    no equilibrium
    """
    warn_of_units(case)
    check_fixed_sizes(case, "modes")
    progress("linearising", 0.0)
    system = looked_at(case, allow_code=allow_code)
    modes = machine_modes(linearize(system, time=time, spin=spin_of(case)), n_modes)
    progress("linearising", 1.0)
    numbers = {"title": case.title, "time": time, **_numbers(case, modes)}
    with file_errors("make the folder", folder):
        folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / f"{case.path.stem}-modes.json", numbers)
    if case.tables.output.pictures or case.tables.output.animation:
        _draw(case, modes, folder, progress)
    return modes, numbers


def campbell_case(
    case: Case,
    folder: Path,
    rates: Sequence[float],
    *,
    n_modes: int = 6,
    allow_code: bool = False,
    progress: Progress = silent,
) -> CampbellDiagram:
    """Modes over the rate of the case's spin; writes `CASE-campbell.json` and a picture.

    Raises CaseError where the case has no spin, and as for `modes_case`.
    """
    warn_of_units(case)
    check_fixed_sizes(case, "modes")
    spin = spin_of(case)
    if spin is None:
        raise CaseError(f"{case.path}: a Campbell diagram needs a spin; add [spin] with rate and axis")
    spins = [Spin(float(rate), spin.axis, spin.point, spin.bodies) for rate in rates]
    system = looked_at(case, allow_code=allow_code)
    diagram = campbell_diagram(
        system, spins, n_modes=n_modes, progress=lambda share: progress("linearising", share)
    )
    with file_errors("make the folder", folder):
        folder.mkdir(parents=True, exist_ok=True)
    write_json(
        folder / f"{case.path.stem}-campbell.json",
        {
            "title": case.title,
            "units": unit_names(case.units),
            "rates": diagram.rates.tolist(),
            "frequencies": _shown(case, diagram.frequencies).tolist(),
            "damping_ratios": diagram.damping_ratios.tolist(),
            "likeness": diagram.likeness.tolist(),
        },
    )
    if case.tables.output.pictures:
        from supple.viz import plot_campbell

        plot_campbell(folder / f"{case.path.stem}-campbell.png", diagram, units=case.units)
    return diagram


def _shown(case: Case, frequencies: np.ndarray) -> np.ndarray:
    """In Hz where the unit of time is said, else one over it."""
    return np.asarray(frequencies) / (2 * np.pi) * case.units.frequency_shown.factor


def _numbers(case: Case, modes: MachineModes) -> dict[str, Any]:
    shares = modes.kinetic_shares
    names = [placed.body.name for placed in modes.machine.system.bodies]
    return {
        "units": unit_names(case.units),
        "modes": [
            {
                "frequency": frequency,
                "damping_ratio": ratio,
                "eigenvalue": [value.real, value.imag],
                "unstable": bool(unstable),
                "kinetic_share": dict(zip(names, share, strict=True)),
            }
            for frequency, ratio, value, unstable, share in zip(
                _shown(case, modes.frequencies).tolist(),
                modes.damping_ratios.tolist(),
                modes.eigenvalues,
                modes.unstable,
                shares.T.tolist(),
                strict=True,
            )
        ],
    }


def _draw(case: Case, modes: MachineModes, folder: Path, progress: Progress) -> None:
    from supple.viz import animate_run, draw_machine, mode_titles

    titles = mode_titles(modes.frequencies / (2 * np.pi), case.units)
    system = replace(modes.machine.system, loads=())
    size = system_length(system)
    for number in range(len(modes.eigenvalues)):
        motion = mode_motion(modes, number, amplitude=AMPLITUDE * size)
        stem = f"{case.path.stem}-mode-{number + 1}"
        if case.tables.output.pictures:
            draw_machine(
                folder / f"{stem}.png", system, motion, case.drawn, title=titles[number], units=case.units
            )
        if case.tables.output.animation:
            animate_run(folder / f"{stem}.gif", system, motion, case.drawn, units=case.units)
        progress("drawing modes", (number + 1) / len(modes.eigenvalues))
