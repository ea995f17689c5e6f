"""The report of a run: one page with its motion, its curves, its tables and its inputs."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import Any

from supple.arguments import checked_arguments
from supple.fem import FiniteElementModel
from supple.integrate import Solution
from supple.machine import At, System
from supple.quantities import Reading, TrackedMotion
from supple.report.charts import charts_of
from supple.report.moving_machine import moving_machine
from supple.report.page import Page, PageSection, write_page
from supple.results import summarize
from supple.results.body_surface import Look
from supple.results.explicit_numbers import explicit_cost_line
from supple.results.run_start import start_lines
from supple.results.run_tables import correction_table, cost_line, error_lines, error_table, motion_tables
from supple.units import UNNAMED, UnitSystem

__all__ = ["write_report"]


@checked_arguments
def write_report(
    path: Path | str,
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look] = MappingProxyType({}),
    *,
    title: str = "",
    tracked: Mapping[str, TrackedMotion] = MappingProxyType({}),
    readings: Sequence[Reading] = (),
    elements: Mapping[str, FiniteElementModel] | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    numbers: Mapping[str, Any] | None = None,
    rounds: Sequence[Mapping[str, Any]] = (),
    inputs: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Write a run as one HTML page that needs no network: its motion in 3-D, curves, tables, inputs.

    Displacements in the page agree with `node_positions` to 1e-4 of the largest displacement.

    Parameters
    ----------
    meshes : by name of a deformable body, its mesh, or its elements, which contain the beam sections; other
        deformable bodies are drawn as points
    title : title of the page; by default "Report of a run"
    tracked, readings : motions of places and readings of sensors, drawn as curves besides the loads of joints
    elements : of bodies, by name, for colours by von Mises stress; see `von_mises_history`
    bases : reference interfaces of deflections, by body; by default the first interface of the body
    numbers : result of `summarize`; by default it is computed here
    rounds : of a self-correction, from `correction_numbers`
    inputs : texts to include, such as the case file, by name
    units : of the model; no unit is written for units without names

    Raises
    ------
    ModelError          as for `summarize` and `von_mises_history`
    ResultFileError     the file cannot be written
    """
    known = numbers or summarize(system, solution, tracked, units=units)
    charts = charts_of(system, solution, tracked=tracked, readings=readings, units=units)
    page = Page(
        title or "Report of a run",
        [*run_sections(known, solution, rounds, units), inputs_section(inputs)],
        moving_machine(system, solution, meshes, elements=elements, bases=bases, units=units),
        charts=list(charts),
        units=units,
    )
    return write_page(path, page)


def run_sections(
    numbers: Mapping[str, Any], solution: Solution, rounds: Sequence[Mapping[str, Any]], units: UnitSystem
) -> list[PageSection]:
    """Sections of a run: first its error estimate, then all its other tables."""
    if numbers["errors"]:
        error = PageSection("Error of the run", list(error_lines(numbers)), [error_table(numbers)])
    else:
        error = PageSection("Error of the run", ["The error of this run was not estimated."])
    corrected = [correction_table(rounds, units)] if rounds else []
    proofs = [
        f"{name}: {body['eigenvalues']}" for name, body in numbers["bodies"].items() if "eigenvalues" in body
    ]
    cost = explicit_cost_line(numbers) if "steps" in numbers else cost_line(solution.statistics)
    stopped = [f"Stopped at {solution.times[-1]:g}: {solution.stopped}"] if solution.stopped else []
    lines = [*stopped, *proofs, *start_lines(numbers), cost]
    return [error, PageSection("Results", lines, [*corrected, *motion_tables(numbers)])]


def inputs_section(inputs: Mapping[str, str]) -> PageSection:
    """Input texts and program versions of the run."""
    programs = [f"{name} {version(name)}" for name in ("supple", "numpy", "scipy", "jax")]
    line = f"Computed with {', '.join(programs)}; Python {platform.python_version()}."
    return PageSection("Inputs and versions", [line], texts=inputs)
