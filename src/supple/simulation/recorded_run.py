"""A simulation that lives on disk: begun, continued where it was cut off, read where it is complete."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from supple.errors import ResultFileError
from supple.integrate import Progress, Run, Solution
from supple.machine import System
from supple.simulation.recorded_columns import check_columns, columns_of
from supple.simulation.watched_run import watched_run
from supple.storage import ResultFile, read_header, read_last_instant, read_solution
from supple.storage.dataset_labels import second_end_key
from supple.storage.result_reader import Metadata


def begin_recorded(
    system: System,
    run: Run,
    path: Path | str,
    *,
    case: str,
    metadata: Metadata = MappingProxyType({}),
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Simulate a system from its start, keeping every finished part in a result file, new or replaced.

    Parameters
    ----------
    system, run, progress, check : as for `simulate`
    path : file to write; its folder is made
    case, metadata      kept in the file, to continue it and for the record; "units", `str` of a UnitSystem,
                        name the units of its arrays

    Raises
    ------
    ResultFileError     the file cannot be written (a full disk, say)
    errors of `simulate`; what was computed until then is kept in the file
    """
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    metadata = {**metadata, **joint_ends(system), **columns_of(system)}
    return _recorded(
        system, run, ResultFile.create(path, case=case, metadata=metadata), None, progress, check
    )


def joint_ends(system: System) -> Metadata:
    """Metadata that say which end the forces of each joint act on."""
    return {second_end_key(joint.name): str(joint.second) for joint in system.joints}


def continue_recorded(
    system: System,
    run: Run,
    path: Path | str,
    *,
    case: str,
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Simulate the rest of a run that was cut off, from the last instant its result file holds.

    Parameters and errors as for `begin_recorded`; also

    ResultFileError     no such file, or its run is complete, of another case, or without any output; a
                        reduced body is not the one that it was begun with
    """
    check_columns(read_header(path), system, path)
    start = read_last_instant(path)
    return _recorded(system, run, ResultFile.resume(path, case=case), start, progress, check)


def simulate_recorded(
    system: System,
    run: Run,
    path: Path | str,
    *,
    case: str,
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Simulate a system unless its result file holds the run: begin it, or continue what was cut off.

    Parameters
    ----------
    system, run, progress, check : as for `simulate`
    path : file to write; its folder is made
    case : str      says what is simulated; a file of another case is never overwritten nor continued

    Returns
    -------
    Solution    the whole run, from its start

    Raises
    ------
    ResultFileError     the file holds another case, or motions of reduced bodies other than those given, or
                        cannot be read or written (a full disk, say)
    errors of `simulate`; what was computed until then is kept in the file
    """
    path = Path(path)
    if not path.exists():
        return begin_recorded(system, run, path, case=case, progress=progress, check=check)
    header = read_header(path)
    if header.case != case:
        raise ResultFileError(
            f"{path} holds another run than the one asked for; delete it or choose another folder. "
            f"There: {header.case}. Here: {case}"
        )
    check_columns(header, system, path)
    if header.complete:
        if progress is not None:
            progress(1.0)
        return read_solution(path)
    # A run that ended before its first output left nothing to continue from.
    proceed = continue_recorded if header.n_times else begin_recorded
    return proceed(system, run, path, case=case, progress=progress, check=check)


def _recorded(
    system: System,
    run: Run,
    file: ResultFile,
    start: Solution | None,
    progress: Progress | None,
    check: bool,
) -> Solution:
    with file:
        done = watched_run(system, run, resume=start, record=file.append, progress=progress, check=check)
        if done.stopped is None:
            file.finish()
    return replace(read_solution(file.path), stopped=done.stopped)
