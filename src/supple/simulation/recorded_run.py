"""A simulation recorded in a file: started, continued after an interruption, read when complete."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from supple.errors import ResultFileError
from supple.integrate import Progress, Run, Solution
from supple.machine import System
from supple.methods.intrinsic.truncation_error import truncation_parts
from supple.simulation.description import inputs_of
from supple.simulation.interruption import noted_interruption
from supple.simulation.recorded_columns import check_columns, columns_of
from supple.simulation.watched_run import watched_run
from supple.storage import ResultFile, read_header, read_solution
from supple.storage.dataset_labels import second_end_key
from supple.storage.result_content import Metadata, ResultHeader
from supple.storage.run_inputs import Inputs, changes

__all__ = ["simulate_recorded"]


def motion_metadata(system: System) -> Metadata:
    """Metadata of the motion of a system: the end that the forces of each joint act on, and its bodies."""
    ends = {second_end_key(joint.name): str(joint.second) for joint in system.joints}
    return {**ends, **columns_of(system)}


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
    inputs : inputs of the motion, stored in the file; by default from the system, the run and the case
        (`inputs_of`). Without `overwrite`, a file with other inputs is neither replaced nor continued
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
    header = None
    if path.exists() and not overwrite:
        header = check_recorded(system, run, path, case=case, inputs=inputs)
    if header is None or not header.n_times:  # nothing to continue from
        metadata = motion_metadata(system)
        file = ResultFile.create(path, case=case, metadata=metadata, inputs=inputs, overwrite=overwrite)
    elif header.complete:
        if progress is not None:
            progress(1.0)
        whole = read_solution(path)
        return replace(whole, truncation=truncation_parts(system, whole))
    else:
        file = ResultFile.resume(path, case=case, inputs=inputs)
    with file:
        return recorded(system, run, file, progress=progress, check=check)


def check_recorded(
    system: System, run: Run, path: Path, *, case: str, inputs: Inputs | None = None
) -> ResultHeader:
    """The header of the file of a run; ResultFileError if the file has another run, or other bodies."""
    header = read_header(path)
    changed = changes(header.inputs, inputs_of(system, run, case) if inputs is None else inputs)
    if changed:
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
