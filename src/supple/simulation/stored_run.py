"""A run with its result file and reduced bodies in one folder, started or continued after an interruption."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from types import MappingProxyType

from supple.integrate import Progress, Run, Solution
from supple.machine import System
from supple.simulation.recorded_columns import check_columns
from supple.simulation.recorded_run import motion_metadata, recorded
from supple.simulation.stored_bodies import store_bodies, with_stored_bodies
from supple.storage import ResultFile, read_header
from supple.storage.result_content import Metadata
from supple.storage.run_inputs import Inputs

__all__ = ["simulate_and_store"]


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
    system, run, progress : as for `simulate`
    path : file to write; its folder is created
    case, metadata, inputs : stored in the file, see `ResultHeader`; entry "units" of the metadata, `str` of a
        UnitSystem, gives the units of its arrays
    overwrite : replace an existing result; otherwise only a run without any output is replaced
    kept : names of the bodies to store; only reduced bodies are stored
    resume : continue an interrupted run, with the stored bodies of this run

    Returns
    -------
    the system as simulated, and the whole run

    Raises
    ------
    ResultFileError     the file cannot be written, or its run cannot be continued
    errors of `simulate`; the results until then are in the file
    """
    header = read_header(path) if resume else None
    if header is not None and header.n_times:
        system = with_stored_bodies(system, kept, path.parent)
        check_columns(header, system, path)
        with ResultFile.resume(path, case=case, inputs=inputs) as file:
            return system, recorded(system, run, file, progress=progress)
    if header is not None:
        # Nothing was computed yet. The stored bodies may be those of an earlier run.
        ResultFile.resume(path, case=case, inputs=inputs).close()
    metadata = {**metadata, **motion_metadata(system)}
    # The old motion is deleted before its bodies, so that it is never beside the bodies of another run.
    with ResultFile.create(path, case=case, metadata=metadata, inputs=inputs, overwrite=overwrite) as file:
        store_bodies(system, kept, path.parent)
        return system, recorded(system, run, file, progress=progress)
