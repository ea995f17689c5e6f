"""The equilibrium of a case, at rest or in steady rotation."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from supple.cases.case import Case
from supple.cases.continuation import StartState, continued_from
from supple.cases.drawing import check_drawing
from supple.cases.implausible_units import warn_of_units
from supple.cases.notify import silent
from supple.cases.run_files import write_numbers
from supple.error import correct_at_rest
from supple.errors import CaseError, ControlWarning
from supple.integrate import StepProgress
from supple.machine import Controller, Spin, System
from supple.quantities import TrackedMotion, read_sensors, tracked_places
from supple.results import summarize
from supple.simulation import AssembledMachine, Equilibrium, assemble, equilibrium, place_errors
from supple.simulation.resting_state import placed_at_rest, resting_state
from supple.simulation.turned_machine import warn_of_varying_loads

__all__ = ["StaticResult", "static_case"]


@dataclass(frozen=True, eq=False)
class StaticResult:
    """An equilibrium, the tracked places of the case, and its numbers from `summarize`."""

    found: Equilibrium
    tracked: Mapping[str, TrackedMotion]
    numbers: Mapping[str, Any]


def spin_of(case: Case) -> Spin | None:
    """The steady rotation of the case; split bodies are replaced by their parts."""
    spin = case.tables.spin
    if spin is None:
        return None
    made = spin.build()
    return made if made.bodies is None else replace(made, bodies=case.names_in_machine(made.bodies))


def analysed_system(case: Case, *, time: float = 0.0, allow_code: bool) -> System:
    """The machine for its equilibrium or modes, assembled on request at a time, with its allowed controllers.

    Issues ControlWarning if the code may not run; raises CaseError for code that fails.
    """
    control = case.tables.control
    if control is not None and not allow_code:
        warnings.warn(
            f'the machine is analysed without its controllers, control = "{control}": review that code, '
            "and give --allow-code to include them",
            ControlWarning,
            stacklevel=2,
        )
        return assembled_system(case, time)
    return case.controlled(assembled_system(case, time), allow_code=allow_code)


def starting_system(case: Case, simulated: System | None = None, *, allow_code: bool = False) -> System:
    """The machine at the start of its run: as placed (and assembled on request), in equilibrium, or in a
    state of an earlier run.

    simulated : the machine with the bodies of a run, from `result_machine`; by default the case's machine

    For bodies with a self-correcting reduction, the equilibrium is that of the full body. The bases of all
    rounds contain its deformed shape.

    The controllers are created for the machine as placed. Traced controllers act in the equilibrium; sampled
    controllers are first called at the start of the run.

    Raises
    ------
    CaseError           a kinematic run with a self-correcting reduction; code that is not allowed or fails
    errors of `continued_from`
    ConvergenceError    no equilibrium; joints that cannot be closed
    """
    wanted = case.tables.simulation
    if wanted.kinematic and simulated is None and case.starts:
        raise CaseError(
            f"{case.path}: body '{next(iter(case.starts))}' has a self-correcting reduction: for a "
            "run with kinematic = true give it a basis of fixed size, such as reduction = "
            '{ basis = "craig-bampton", modes = 10 } without accuracy'
        )
    placed = assembled_system(case) if simulated is None else simulated
    system = case.controlled(placed, allow_code=allow_code)
    if isinstance(wanted.start, StartState):
        return continued_from(wanted.start, case, system)
    if wanted.start == "placed":
        return system
    case.notify("searching for the equilibrium")
    traced = tuple(each for each in system.controllers if isinstance(each, Controller))
    acting = replace(system, controllers=traced)
    # A run needs only the equilibrium, neither its stability nor its forces.
    state = resting_state(acting, time=case.run.start, spin=spin_of(case))
    warn_of_varying_loads(state, case.run.start, spin_of(case))
    found = placed_at_rest(state)
    resting = iter(found.controllers)
    controllers = tuple(next(resting) if isinstance(own, Controller) else own for own in system.controllers)
    return replace(found, controllers=controllers)


def assembled_system(case: Case, time: float | None = None) -> System:
    """The machine as placed, or assembled if the case requests it; errors as for `starting_system`.

    time : time at which the laws of joints are evaluated; by default the start of the run
    """
    if not case.tables.simulation.assemble:
        return case.system
    found = assemble(case.system, time=case.run.start if time is None else time)
    case.notify(_assembly_line(found))
    return found.system


def _assembly_line(found: AssembledMachine) -> str:
    """One line on the motion of bodies in assembly."""
    moved = [
        f"'{each.body}' by {each.distance:.3g} and {np.degrees(each.angle):.3g} deg"
        for each in found.moved
        if each.distance or each.angle
    ]
    return "assembled: moved " + ", ".join(moved) if moved else "assembled: all joints are closed as placed"


def static_case(
    case: Case,
    folder: Path,
    *,
    time: float = 0.0,
    errors: bool = True,
    allow_code: bool = False,
    progress: StepProgress = silent,
) -> StaticResult:
    """Find the equilibrium of a case; write its numbers (`CASE-static.json`), page and picture.

    folder : created if missing
    time : time at which loads and laws are evaluated
    errors : estimate the error of the bases, which requires factorisations of the full bodies
    allow_code : whether the controllers of the case may run

    Raises
    ------
    CaseError               code that fails; a drawing library that is missing
    SelfCorrectionError     a body that does not reach its accuracy
    ConvergenceError        no equilibrium
    """
    check_drawing(case)
    warn_of_units(case)
    # Errors of sensors are reported before the search, not after it.
    sensors = case.sensors
    system = analysed_system(case, time=time, allow_code=allow_code)

    def searching(_: int, residual: float) -> None:
        # The bar shows the number of correct digits, which Newton's method doubles near the solution.
        progress("searching for the equilibrium", float(np.clip(-np.log10(residual + 1e-300) / 9, 0.0, 1.0)))

    searching(0, 1.0)
    if case.starts:
        found, _ = correct_at_rest(system, case.starts, time=time, spin=spin_of(case))
    else:
        fulls = None if errors else ()
        found = equilibrium(system, time=time, spin=spin_of(case), fulls=fulls, progress=searching)
    progress("searching for the equilibrium", 1.0)
    tracked = tracked_places(found.system, found.solution, case.track, case.bases)
    readings = read_sensors(sensors, found.system, found.solution)
    numbers: dict[str, Any] = {
        "title": case.title,
        "time": time,
        "stable": found.stable,
        **summarize(found.system, found.solution, tracked, fulls=case.fulls, units=case.units),
        "errors": {name: error.plain() for name, error in found.errors.items()},
        "sensors": {each.name: each.plain(case.units) for each in readings},
    }
    for name, error in place_errors(found, case.track, case.bases).items():
        numbers["tracked"][name] |= {
            "error of position": error.position,
            "error of deflection": error.deflection,
        }
    path = write_numbers(case, folder, "static", numbers)
    if case.tables.output.report:
        from supple.report import write_static_report

        write_static_report(
            path.with_suffix(".html"),
            found,
            case.page_looks,
            numbers,
            title=f"{case.title}: equilibrium",
            elements=case.coloured_elements(found.system),
            bases=case.bases,
            inputs=case.texts(case.inputs),
            units=case.units,
        )
    if case.tables.output.pictures:
        from supple.viz import draw_rest

        draw_rest(
            path.with_suffix(".png"),
            found.system,
            found.solution,
            case.drawn,
            elements=case.coloured_elements(found.system),
            bases=case.bases,
            view=case.tables.output.view,
            units=case.units,
        )
    return StaticResult(found, tracked, numbers)
