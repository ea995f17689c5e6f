"""The machine of a result file, from its case file and the bodies beside it."""

from __future__ import annotations

import os
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from supple.cases.case import Case
from supple.cases.notify import Notify, silent
from supple.cases.read_case import read_case
from supple.cases.static_case import assembled_system
from supple.errors import ResultFileError
from supple.integrate import FramedMotion
from supple.machine import Placed, System
from supple.methods.intrinsic.complete_motion import with_modes
from supple.methods.intrinsic.enough_modes import FEWEST
from supple.reduction import ReducedBody
from supple.simulation.recorded_columns import check_columns
from supple.simulation.stored_bodies import stored_path
from supple.storage import ResultParts, read_header, read_reduced_body
from supple.storage.result_content import ResultHeader
from supple.storage.run_inputs import FILE, Inputs, changes

CASE_FILE = "case file"
"""Key in the metadata of a result file: its case file, relative to the folder of the result."""

_READ_AFTERWARDS = ("sensor", "order of sensor", "parameter", "order of parameter", "error")
"""Prefixes of inputs on which the motion does not depend."""


@dataclass(frozen=True, eq=False)
class ResultMachine:
    """A run in a file, and its machine.

    system : without controllers, with bodies as simulated, placed as in the case
    """

    case: Case
    system: System
    run: ResultParts


def path_from(folder: Path, path: Path) -> str:
    """A path relative to a folder; the absolute path on another drive."""
    try:
        return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
    except ValueError:
        return path.resolve().as_posix()


def result_machine(path: Path, case_file: Path | None = None, notify: Notify = silent) -> ResultMachine:
    """The machine of a result file written by `supple run`; nothing is written.

    case_file : present path of its case file; by default the path stored in the result

    Raises
    ------
    ResultFileError     no result; a run without a case file; missing reduced bodies; a case or files that
                        have changed since the run, except for sensors, parameters and error
    errors of `read_case` and of building its machine
    """
    header = read_header(path)
    case = read_case(_case_path(path, header, case_file), notify)
    same_text = header.case == case.text
    changed = changes(*(_of_motion(inputs, same_text) for inputs in (header.inputs, case.inputs)))
    if changed:
        raise ResultFileError(
            f"{path} does not match {case.path} ({changed}): run the case again, or give the case "
            "file it was run from (--case)"
        )
    system = _as_simulated(case, path)
    check_columns(header, system, path, with_start=False)
    return ResultMachine(case, system, ResultParts(path))


def _case_path(path: Path, header: ResultHeader, given: Path | None) -> Path:
    if given is not None:
        return given
    named = header.metadata.get(CASE_FILE)
    if named is None:
        raise ResultFileError(f"{path} does not name its case file: give it (--case FILE)")
    found = path.resolve().parent / str(named)
    if not found.is_file():
        raise ResultFileError(
            f"{path} was run from {found}, which no longer exists: give its case file (--case FILE)"
        )
    return found


def _of_motion(inputs: Inputs, same_text: bool) -> Inputs:
    """Inputs to compare: only files if the case has the same text, because later versions add keys."""
    if same_text:
        return {name: value for name, value in inputs.items() if name.startswith(FILE)}
    return {name: value for name, value in inputs.items() if not name.startswith(_READ_AFTERWARDS)}


def _as_simulated(case: Case, path: Path) -> System:
    system = assembled_system(case)
    reduced: Collection[str] = {*system.bodies_of(ReducedBody), *case.starts} & case.made_here
    counted = {
        table.name
        for table in case.parts.body
        if table.condense is not None and table.condense.accuracy is not None
    }
    return replace(
        system,
        bodies=tuple(
            _kept(placed, path)
            if placed.body.name in reduced
            else _with_recorded_modes(placed, path)
            if placed.body.name in counted
            else placed
            for placed in system.bodies
        ),
    )


def _kept(placed: Placed, path: Path) -> Placed:
    kept = stored_path(path.parent, placed.body.name)
    if not kept.exists():
        raise ResultFileError(
            f"{kept} is missing: the motion in {path} needs this reduced body; restore it, or run the "
            "case again"
        )
    return replace(
        placed,
        body=read_reduced_body(kept),
        coordinates=np.zeros(0),
        coordinate_rates=np.zeros(0),
    )


def _with_recorded_modes(placed: Placed, path: Path) -> Placed:
    """The body with the number of modes that its run found by doubling."""
    (instant,) = ResultParts(path, [0])
    recorded = instant.motion(placed.body.name, FramedMotion).coordinates.shape[1]
    number, whole = FEWEST, with_modes(placed, None)
    while number < whole.body.n_coordinates:
        found = with_modes(placed, number)
        if found.body.n_coordinates == recorded:
            return found
        number *= 2
    return whole
