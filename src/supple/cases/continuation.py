"""Start of a run from a stored time of an earlier run, whose result and reduced bodies are in one folder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import Field

from supple.cases.shared_rules import FileName
from supple.errors import CaseError
from supple.importers.toml import CheckedTable
from supple.machine import Placed, System
from supple.simulation import Start
from supple.simulation.recorded_columns import are_same_columns
from supple.simulation.start import ProjectionLoss
from supple.simulation.stored_bodies import stored_path
from supple.storage import read_header, read_reduced_body, read_solution
from supple.units import UnitSystem

if TYPE_CHECKING:
    from supple.cases.case import Case


class StartState(CheckedTable):
    """A time of an earlier run at which this run begins."""

    file: FileName = Field(description="result file of the earlier run")
    time: float = Field(description="output time of the earlier run at which this run starts, a time")


def continued_from(state: StartState, case: Case, system: System) -> System:
    """The machine of a case with the state of an earlier run, in the units of the case.

    Raises
    ------
    CaseError           a unit of length or time that only one of file and case states
    ResultFileError     a file that cannot be read
    ModelError          as `Start.place`
    """
    path = case.folder / state.file
    header, solution = read_header(path), read_solution(path)
    length, time = _scales(case, path, UnitSystem.parsed(str(header.metadata.get("units", ""))))
    moved = list(_bodies_that_moved(case, system, path.parent, solution.columns))
    start = Start(solution, state.time, System(moved) if moved else None, length=length, duration=time)
    found = start.place(system)
    losses = {name: loss for name, loss in found.losses.items() if max(loss.relative, loss.rate) > 0}
    lost = "; ".join(f"body '{name}' {_words(loss)}" for name, loss in losses.items())
    case.notify(f"starts from {state.file} at t = {found.time:g}" + (f": {lost}" if lost else ""))
    return found.system


def _words(loss: ProjectionLoss) -> str:
    return (
        f"is projected on its basis, which lacks {100 * loss.relative:.2g} % of its deformation "
        f"({loss.rms:.2g} RMS) and {100 * loss.rate:.2g} % of the rates"
    )


def _scales(case: Case, path: Path, there: UnitSystem) -> tuple[float, float]:
    """Length and time unit of a file, as multiples of the units of the case; 1.0 if neither states a unit.

    Raises CaseError if only one of the two states a unit.
    """
    here, ratios = case.units, []
    for name in ("length", "time"):
        ours, theirs = here.in_si(**{name: 1}), there.in_si(**{name: 1})
        if (ours is None) != (theirs is None):
            silent, stated = (case.path, path) if ours is None else (path, case.path)
            raise CaseError(
                f"{stated} gives its unit of {name}, and {silent} does not: give the units in both cases, so "
                "that the state can be converted"
            )
        ratios.append(1.0 if ours is None or theirs is None else theirs / ours)
    return ratios[0], ratios[1]


def _bodies_that_moved(
    case: Case, system: System, folder: Path, columns: Mapping[str, Mapping[str, Any]]
) -> Iterator[Placed]:
    """The bodies of the earlier run: reduced bodies from their files, and bodies that were not reduced."""
    fulls = case.fulls
    for name in (placed.body.name for placed in system.bodies):
        if (kept := stored_path(folder, name)).exists():
            yield Placed(read_reduced_body(kept))
        elif name in fulls and are_same_columns(columns.get(name, {}), Placed(fulls[name])):
            yield Placed(fulls[name])
