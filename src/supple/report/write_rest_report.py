"""The report of an equilibrium, and those of modes about it: shapes that are played, Campbell diagrams."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from supple.arguments import checked_arguments
from supple.equations.build_model import system_length
from supple.fem import FiniteElementModel
from supple.integrate.solution import concatenate
from supple.linearization import CampbellDiagram, MachineModes, mode_motion
from supple.machine import At
from supple.mesh import Mesh
from supple.report.charts import Chart
from supple.report.moving_machine import FieldScale, moving_machine
from supple.report.page import Clip, Page, Section, write_page
from supple.report.write_report import inputs_section
from supple.results.rest_tables import rest_error_table
from supple.results.run_tables import motion_tables
from supple.simulation import Equilibrium
from supple.units import UNNAMED, UnitSystem, labelled, measured

__all__ = ["write_campbell_report", "write_modes_report", "write_static_report"]

AMPLITUDE = 0.1
"""Of a mode, as a share of the machine's size."""
_PERCENT = 100.0


@checked_arguments
def write_static_report(
    path: Path | str,
    found: Equilibrium,
    meshes: Mapping[str, Mesh],
    numbers: Mapping[str, Any],
    *,
    title: str = "",
    elements: Mapping[str, FiniteElementModel] | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    inputs: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Write an equilibrium as a page; parameters as for `write_report`, numbers as of a static case."""
    known = [rest_error_table(numbers)] if found.errors else []
    lines = [] if known else ["The error of the bases was not estimated."]
    stable = {True: "stable", False: "unstable", None: "of unknown stability"}[found.stable]
    state = f"The equilibrium is {stable}; found after {found.iterations} iterations."
    page = Page(
        title or "Equilibrium",
        [
            Section("Error of the bases", lines, known),
            Section("Results", [state], motion_tables(numbers)),
            inputs_section(inputs),
        ],
        moving_machine(found.system, found.solution, meshes, elements=elements, bases=bases, units=units),
        units=units,
    )
    return write_page(path, page)


@checked_arguments
def write_modes_report(
    path: Path | str,
    modes: MachineModes,
    meshes: Mapping[str, Mesh] = MappingProxyType({}),
    *,
    axes: str = "",
    chosen: Sequence[int] | None = None,
    title: str = "",
    bases: Mapping[str, At] = MappingProxyType({}),
    inputs: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Write modes as a page that plays each of them, its decay left out, at a tenth of the machine's size.

    axes : that frequencies are seen in, in words
    chosen : numbers from 0 of the modes that are played; all are listed
    Others as for `write_report`.
    """
    notes = [_mode_note(modes, number, units) for number in range(len(modes.eigenvalues))]
    seen = f"Frequencies are seen in axes {axes}." if axes else ""
    played = list(range(len(notes))) if chosen is None else list(chosen)
    machine, clips = None, []
    if played:
        system = replace(modes.machine.system, loads=())
        size = AMPLITUDE * system_length(system)
        motions = [mode_motion(modes, number, amplitude=size) for number in played]
        whole = moving_machine(system, concatenate(motions), meshes, bases=bases, units=units)
        # A mode has no size of its own: colours are shares of the largest.
        scales = {
            name: FieldScale(f"{name}, share of the largest", 1 / scale.high if scale.high else 1.0, 0.0, 1.0)
            for name, scale in whole.scales.items()
        }
        machine = replace(whole, scales=scales)
        length = len(motions[0].times)
        clips = [
            Clip(
                f"mode {number + 1}",
                place * length,
                length,
                " ".join([f"{notes[number]}.", seen]),
                repeats=True,
            )
            for place, number in enumerate(played)
        ]
    lines = [seen, *(f"mode {number + 1}: {note}" for number, note in enumerate(notes))]
    sections = [Section("Modes", [line for line in lines if line]), inputs_section(inputs)]
    return write_page(path, Page(title or "Modes", sections, machine, clips, units=units))


@checked_arguments
def write_campbell_report(
    path: Path | str,
    diagram: CampbellDiagram,
    *,
    axes: str = "",
    title: str = "",
    inputs: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Write frequencies and damping over speed as a page whose curves are named at the pointer."""
    per_minute = units.in_si(time=-1)
    speed = diagram.rates * (1.0 if per_minute is None else per_minute * 60 / (2 * np.pi))
    over = "rad per unit of time" if per_minute is None else "rotor speed (rpm)"
    unit, factor = units.frequency_shown
    note = f"seen in axes {axes}" if axes else ""

    def curves(values: np.ndarray) -> dict[str, np.ndarray]:
        return {f"mode {number + 1}": own for number, own in enumerate(values.T)}

    shown = factor * diagram.frequencies / (2 * np.pi)
    charts = [
        Chart("frequencies", labelled("frequency", unit), speed, curves(shown), note, over),
        Chart("damping", "damping (%)", speed, curves(_PERCENT * diagram.damping_ratios), note, over),
    ]
    known = np.full(0, 0.0) if diagram.errors is None else diagram.errors[np.isfinite(diagram.errors)]
    error = (
        f"Largest error of a frequency by the bases: {_PERCENT * known.max():.2g} %." if known.size else ""
    )
    lines = [error or "The error of the bases is not known."]
    page = Page(
        title or "Campbell diagram",
        [Section("Error of the bases", lines), inputs_section(inputs)],
        charts=charts,
        units=units,
    )
    return write_page(path, page)


def _mode_note(modes: MachineModes, number: int, units: UnitSystem) -> str:
    """Frequency, damping, error by the bases, stability."""
    unit, factor = units.frequency_shown
    words = [
        measured(f"{factor * modes.frequencies[number] / (2 * np.pi):.5g}", unit),
        f"damping {_PERCENT * modes.damping_ratios[number]:.3g} %",
    ]
    if modes.error is not None and np.isfinite(off := modes.error.relative[number]):
        words.append(f"error by the bases {_PERCENT * off:.2g} %")
    if modes.unstable[number]:
        words.append("unstable")
    return ", ".join(words)
