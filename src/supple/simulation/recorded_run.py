"""A simulation recorded in a file: started, continued after an interruption, read when complete."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from supple.errors import ResultFileError
from supple.integrate import Progress, Run, Solution
from supple.machine import System
from supple.methods.intrinsic.report_truncation import truncation_parts
from supple.simulation.description import inputs_of
from supple.simulation.interruption import noted_interruption
from supple.simulation.recorded_columns import check_columns, columns_of
from supple.simulation.stored_bodies import store_bodies, with_stored_bodies
from supple.simulation.watched_run import watched_run
from supple.storage import ResultFile, read_header, read_solution
from supple.storage.dataset_labels import second_end_key
from supple.storage.result_content import Metadata, ResultHeader
from supple.storage.run_inputs import Inputs, changes

__all__ = ["begin_recorded", "continue_recorded", "simulate_and_store", "simulate_recorded"]


def begin_recorded(
    system: System,
    run: Run,
    path: Path | str,
    *,
    case: str,
    metadata: Metadata = MappingProxyType({}),
    inputs: Inputs | None = None,
    kept: Collection[str] = (),
    overwrite: bool = False,
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Simulate a system from its start, and write every completed part to a result file.

    Parameters
    ----------
    system, run, progress, check : as for `simulate`
    path : file to write; its folder is created
    case, metadata : stored in the file; entry "units", `str` of a UnitSystem, gives the units of its arrays
    inputs : inputs of the motion, stored in the file for continuation; by default from the system, the run
        and the case (`inputs_of`)
    kept : names of reduced bodies to store in the folder of the file
    overwrite : replace an existing result; otherwise only a run without any output is replaced

    Raises
    ------
    ResultFileError     a result exists and `overwrite` is False; another run writes the file; the file cannot
                        be written (a full disk)
    errors of `simulate`; the results until then are in the file
    """
    file = ResultFile.create(
        path,
        case=case,
        metadata={**metadata, **joint_ends(system), **columns_of(system)},
        inputs=inputs_of(system, run, case) if inputs is None else inputs,
        overwrite=overwrite,
    )
    # The old motion is deleted before its bodies, so that it is never beside the bodies of another run.
    with file:
        store_bodies(system, kept, Path(path).parent)
        return recorded(system, run, file, progress=progress, check=check)


def simulate_and_store(
    system: System,
    run: Run,
    path: Path,
    kept: Collection[str],
    *,
    case: str,
    inputs: Inputs,
    metadata: Metadata = MappingProxyType({}),
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> tuple[System, Solution]:
    """Simulate a system, and store its motion and its reduced bodies (`NAME-reduced.h5`) in one folder.

    Parameters
    ----------
    resume : continue an interrupted run, with the stored bodies of this run
    Other parameters as for `begin_recorded`.

    Returns
    -------
    the system as simulated, and the whole run

    Raises
    ------
    ResultFileError     the file cannot be written, or its run cannot be continued
    errors of `simulate`; the results until then are in the file
    """
    if resume and read_header(path).n_times:
        system = with_stored_bodies(system, kept, path.parent)
        return system, continue_recorded(system, run, path, case=case, inputs=inputs, progress=progress)
    if resume:
        # Nothing was computed yet. The stored bodies may be those of an earlier run.
        ResultFile.resume(path, case=case, inputs=inputs).close()
    options: dict[str, Any] = {"metadata": metadata, "kept": kept, "overwrite": overwrite}
    return system, begin_recorded(system, run, path, case=case, inputs=inputs, progress=progress, **options)


def joint_ends(system: System) -> Metadata:
    """Metadata with the end on which the forces of each joint act."""
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
    """Simulate the missing part of an interrupted run, from the last time in its result file.

    Parameters and errors are those of `begin_recorded`; also

    ResultFileError     no such file; its run is complete; inputs have changed (the message lists them); a
                        body is not the original one
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
    """Return the run in a result file if it is complete; otherwise start it, or continue its interrupted run.

    Parameters
    ----------
    system, run, progress, check : as for `simulate`
    path : file to write; its folder is created
    case : str      description of the simulation
    inputs : as for `begin_recorded`; without `overwrite`, a file with other inputs is neither replaced nor
        continued
    overwrite : start a new run, whatever the file contains

    Returns
    -------
    Solution    the whole run, from its start

    Raises
    ------
    ResultFileError     the file has another run, or motions of bodies other than those given; another run
                        is writing it; it cannot be read or written (a full disk)
    errors of `simulate`; the results until then are in the file
    """
    path = Path(path)
    inputs = inputs_of(system, run, case) if inputs is None else inputs
    marching: dict[str, Any] = {"case": case, "inputs": inputs, "progress": progress, "check": check}
    if overwrite or not path.exists():
        return begin_recorded(system, run, path, overwrite=overwrite, **marching)
    header = check_recorded(system, run, path, case=case, inputs=inputs)
    if not header.n_times:
        # A run that ended before its first output left nothing to continue from.
        return begin_recorded(system, run, path, **marching)
    if header.complete:
        if progress is not None:
            progress(1.0)
        whole = read_solution(path)
        return replace(whole, truncation=truncation_parts(system, whole))
    return continue_recorded(system, run, path, **marching)


def check_recorded(
    system: System, run: Run, path: Path, *, case: str, inputs: Inputs | None = None
) -> ResultHeader:
    """The header of the file of a run; ResultFileError if the file has another run, or other bodies."""
    header = read_header(path)
    if changed := changes(header.inputs, inputs_of(system, run, case) if inputs is None else inputs):
        raise ResultFileError(
            f"{path} contains another run than requested ({changed}); set overwrite=True to replace it, "
            f"or choose another file. In the file: {header.case}. Requested: {case}"
        )
    if header.n_times:
        check_columns(header, system, path)
    return header


def recorded(
    system: System,
    run: Run,
    file: ResultFile,
    *,
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Simulate the missing part of a run and append it to its result file; returns the whole run."""
    start = file.last_instant() if file.header.n_times else None
    stopped, truncation = None, None
    # A run interrupted after its last output time only has to be marked as complete.
    if start is None or start.times[-1] < run.times[-1] - 1e-6 * run.output_step:
        with noted_interruption(file):
            done = watched_run(system, run, resume=start, record=file.append, progress=progress, check=check)
        stopped = done.stopped
        truncation = done.truncation if start is None else None  # a resumed run estimates only its part
    # From the open file, under its lock: the motion cannot be that of another run.
    whole = file.solution()
    if stopped is None:
        file.finish()
    whole = replace(whole, stopped=stopped)
    return replace(whole, truncation=truncation_parts(system, whole) if truncation is None else truncation)
