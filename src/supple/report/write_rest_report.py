"""Reports of an equilibrium, of modes about it, and of a Campbell diagram."""

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
from supple.linearization.linear_machine import STANDING
from supple.linearization.mode_names import mode_names
from supple.machine import At
from supple.report.charts import Chart
from supple.report.moving_machine import FieldScale, moving_machine
from supple.report.page import Clip, Page, PageSection, write_page
from supple.report.write_report import inputs_section
from supple.results.body_surface import Look
from supple.results.rest_tables import rest_error_table, rest_tables
from supple.results.run_tables import TextTable
from supple.simulation import Equilibrium
from supple.units import UNNAMED, UnitSystem, labelled, plain_number, with_unit

__all__ = ["write_campbell_report", "write_modes_report", "write_static_report"]

AMPLITUDE = 0.1
"""Amplitude of a mode, relative to the machine's size."""
_PERCENT = 100.0
_ORDERS = (1, 2, 3, 4)
"""Multiples of the speed in a Campbell diagram."""


@checked_arguments
def write_static_report(
    path: Path | str,
    found: Equilibrium,
    meshes: Mapping[str, Look],
    numbers: Mapping[str, Any],
    *,
    title: str = "",
    elements: Mapping[str, FiniteElementModel] | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    inputs: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Write an equilibrium as a page.

    numbers : numbers of the results of a static case, as `cases.static_case` returns them
    Other parameters as for `write_report`.
    """
    known = [rest_error_table(numbers)] if found.errors else []
    lines = [] if known else ["The error of the bases was not estimated."]
    stable = {True: "stable", False: "unstable", None: "of unknown stability"}[found.stable]
    state = f"The equilibrium is {stable}; found after {found.iterations} iterations."
    page = Page(
        title or "Equilibrium",
        [
            PageSection("Error of the bases", lines, known),
            PageSection("Results", [state], rest_tables(numbers)),
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
    meshes: Mapping[str, Look] = MappingProxyType({}),
    *,
    tables: Sequence[TextTable] = (),
    chosen: Sequence[int] | None = None,
    title: str = "",
    bases: Mapping[str, At] = MappingProxyType({}),
    inputs: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Write a page that plays each mode without decay; its amplitude is a tenth of the machine's size.

    chosen : numbers from 0 of the modes to play; by default all
    Other parameters as for `write_report`.
    """
    names, seen = mode_names(modes), f"Frequencies are in axes {modes.machine.axes}."
    played = list(range(len(names))) if chosen is None else list(chosen)
    machine, clips = None, []
    if played:
        system = replace(modes.machine.system, loads=())
        size = AMPLITUDE * system_length(system)
        motions = [mode_motion(modes, number, amplitude=size) for number in played]
        whole = moving_machine(system, concatenate(motions), meshes, bases=bases, units=units)
        # The scale of a mode is arbitrary: colours are relative to the largest value.
        scales = {
            name: FieldScale(f"{name}, share of the largest", 1 / scale.high if scale.high else 1.0, 0.0, 1.0)
            for name, scale in whole.scales.items()
        }
        machine = replace(whole, scales=scales)
        length = len(motions[0].times)
        for place, number in enumerate(played):
            note = f"{_mode_note(modes, number, units)}. {seen}"
            clips.append(Clip(f"{number + 1}: {names[number]}", place * length, length, note, repeats=True))
    sections = [PageSection("Modes", [seen], tables), inputs_section(inputs)]
    return write_page(path, Page(title or "Modes", sections, machine, clips, units=units))


@checked_arguments
def write_campbell_report(
    path: Path | str,
    diagram: CampbellDiagram,
    *,
    tables: Sequence[TextTable] = (),
    title: str = "",
    inputs: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Write frequencies and damping over speed as a page; the name of a curve is shown at the pointer.

    Other parameters as for `write_report`.
    """
    (speed_unit, by_rate), (unit, factor) = units.rotation_shown, units.frequency_shown
    speed, over = by_rate * diagram.rates, labelled("speed", speed_unit)
    note = f"seen in axes {diagram.axes}"
    shown = factor / (2 * np.pi) * diagram.frequencies
    # Multiples of the speed that excite modes, up to the highest frequency.
    orders = {f"{order}P": order * factor / (2 * np.pi) * abs(diagram.rates) for order in _ORDERS}
    top = np.nanmax(shown, initial=0.0)
    reached = {name: np.where(own <= 1.1 * top, own, np.nan) for name, own in orders.items()}
    damping = dict(zip(diagram.names, _PERCENT * diagram.observed_damping_ratios.T, strict=True))
    frequencies = dict(zip(diagram.names, shown.T, strict=True)) | reached
    charts = [
        Chart("frequencies", labelled("frequency", unit), speed, frequencies, note, over),
        Chart("damping", "damping (%)", speed, damping, note, over),
    ]
    whirling = np.flatnonzero(np.any(diagram.sense, axis=0))
    if diagram.axes != STANDING and len(whirling):
        charts[1] = replace(charts[1], note=f"{note}; of whirls in space")
        seen = factor / (2 * np.pi) * diagram.in_space.T
        whirls = {diagram.names[mode]: seen[mode] for mode in whirling} | {"1P": orders["1P"]}
        label = labelled("whirl frequency in space", unit)
        charts.insert(0, Chart("whirls", label, speed, whirls, "seen in space", over))
    sections = [PageSection("Modes over speed", [], tables), inputs_section(inputs)]
    return write_page(path, Page(title or "Campbell diagram", sections, charts=charts, units=units))


def _mode_note(modes: MachineModes, number: int, units: UnitSystem) -> str:
    """Frequency, damping, basis error, stability."""
    unit, factor = units.frequency_shown
    words = [
        with_unit(plain_number(factor * modes.frequencies[number] / (2 * np.pi), 5), unit),
        f"damping {_PERCENT * modes.damping_ratios[number]:.3g} %",
    ]
    if modes.error is not None and np.isfinite(off := modes.error.relative[number]):
        words.append(f"error by the bases {_PERCENT * off:.2g} %")
    if modes.unstable[number]:
        words.append("unstable")
    return ", ".join(words)
