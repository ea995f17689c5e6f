"""A simulation that lives on disk: begun, continued where it was cut off, read where it is complete."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from supple.errors import ResultFileError
from supple.integrate import Progress, Run, Solution
from supple.machine import System
from supple.simulation.description import inputs_of
from supple.simulation.interruption import noted_interruption
from supple.simulation.recorded_columns import check_columns, columns_of
from supple.simulation.watched_run import watched_run
from supple.storage import ResultFile, read_header, read_solution
from supple.storage.dataset_labels import second_end_key
from supple.storage.result_content import Metadata, ResultHeader
from supple.storage.run_inputs import Inputs, changes

__all__ = ["begin_recorded", "continue_recorded", "simulate_recorded"]


def begin_recorded(
    system: System,
    run: Run,
    path: Path | str,
    *,
    case: str,
    metadata: Metadata = MappingProxyType({}),
    inputs: Inputs | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Simulate a system from its start, keeping every finished part in a result file.

    Parameters
    ----------
    system, run, progress, check : as for `simulate`
    path : file to write; its folder is made
    case, metadata : kept in the file, for the record; "units", `str` of a UnitSystem, name the units of its
        arrays
    inputs : what the motion depends on, kept in the file to continue it; by default what the system, the run
        and the case give (`inputs_of`)
    overwrite : replace what is there; otherwise only a run without any output is replaced

    Raises
    ------
    ResultFileError     a result is there, or another run writes it; the file cannot be written (a full disk)
    errors of `simulate`; what was computed until then is kept in the file
    """
    file = ResultFile.create(
        path,
        case=case,
        metadata={**metadata, **joint_ends(system), **columns_of(system)},
        inputs=inputs_of(system, run, case) if inputs is None else inputs,
        overwrite=overwrite,
    )
    with file:
        return recorded(system, run, file, progress=progress, check=check)


def joint_ends(system: System) -> Metadata:
    """Metadata that state which end the forces of each joint act on."""
    return {second_end_key(joint.name): str(joint.second) for joint in system.joints}


def continue_recorded(
    system: System,
    run: Run,
    path: Path | str,
    *,
    case: str,
    inputs: Inputs | None = None,
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Simulate the rest of a run that was cut off, from the last instant its result file holds.

    Parameters and errors as for `begin_recorded`; also

    ResultFileError     no such file, or its run is complete, or something it depends on has changed (named);
                        a body is not the one that it was begun with
    """
    inputs = inputs_of(system, run, case) if inputs is None else inputs
    header = read_header(path)
    check_columns(header, system, path)
    with ResultFile.resume(path, case=case, inputs=inputs) as file:
        return recorded(system, run, file, progress=progress, check=check)


def simulate_recorded(
    system: System,
    run: Run,
    path: Path | str,
    *,
    case: str,
    inputs: Inputs | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Simulate a system unless its result file holds the run: begin it, or continue what was cut off.

    Parameters
    ----------
    system, run, progress, check : as for `simulate`
    path : file to write; its folder is made
    case : str      what is simulated, in words
    inputs : as for `begin_recorded`; a file of another run is never overwritten nor continued
    overwrite : begin anew, whatever is there

    Returns
    -------
    Solution    the whole run, from its start

    Raises
    ------
    ResultFileError     the file holds another run, or motions of bodies other than those given; another run
                        is writing it; it cannot be read or written (a full disk, say)
    errors of `simulate`; what was computed until then is kept in the file
    """
    path = Path(path)
    inputs = inputs_of(system, run, case) if inputs is None else inputs
    marching: dict[str, Any] = {"case": case, "inputs": inputs, "progress": progress, "check": check}
    if overwrite or not path.exists():
        return begin_recorded(system, run, path, overwrite=overwrite, **marching)
    header = read_header(path)
    _check_same_run(header, inputs, case, path)
    if not header.n_times:
        # A run that ended before its first output left nothing to continue from.
        return begin_recorded(system, run, path, **marching)
    check_columns(header, system, path)
    if header.complete:
        if progress is not None:
            progress(1.0)
        return read_solution(path)
    return continue_recorded(system, run, path, **marching)


def recorded(
    system: System,
    run: Run,
    file: ResultFile,
    *,
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Simulate what a result file does not hold yet, into it; the whole run, as it is read back."""
    start = file.last_instant() if file.header.n_times else None
    stopped, truncation = None, {}
    # Cut off between its last output time and its end, a run has nothing left to do but to be complete.
    if start is None or _is_something_left(run, start):
        with noted_interruption(file):
            done = watched_run(system, run, resume=start, record=file.append, progress=progress, check=check)
        stopped = done.stopped
        truncation = done.truncation if start is None else {}  # otherwise of a part
    # From the open file, under its lock: nobody else's motion is taken for this one.
    whole = file.solution()
    if stopped is None:
        file.finish()
    return replace(whole, stopped=stopped, truncation=truncation)


def _is_something_left(run: Run, reached: Solution) -> bool:
    return bool(reached.times[-1] < run.times[-1] - 1e-6 * run.output_step)


def _check_same_run(header: ResultHeader, inputs: Inputs, case: str, path: Path) -> None:
    if changed := changes(header.inputs, inputs):
        raise ResultFileError(
            f"{path} holds another run than the one asked for ({changed}); say overwrite=True to replace it, "
            f"or choose another file. There: {header.case}. Here: {case}"
        )
