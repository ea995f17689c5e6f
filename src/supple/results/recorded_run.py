"""A simulation that lives on disk: read where it is complete, continued where it was cut off, else begun."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from supple.errors import ResultFileError
from supple.integrate import Solution
from supple.multibody import Checkpoint, System, simulate
from supple.multibody.simulate import Progress
from supple.results.result_reader import read_header, read_last_instant, read_solution
from supple.results.storage import ResultFile


def simulate_recorded(
    system: System, path: Path | str, *, case: str, progress: Progress | None = None, **options: Any
) -> Solution:
    """Simulate a system, keeping every finished part in a result file, from which the next call goes on.

    Parameters
    ----------
    path : file to write; its folder is made
    case : str      says what is simulated; a file of another case is never overwritten nor continued
    progress, options : as for `simulate`

    Returns
    -------
    Solution    the whole run, from its start

    Raises
    ------
    ResultFileError     the file holds another case, or cannot be read or written (a full disk, say)
    errors of `simulate`; what was computed until then is kept in the file
    """
    path = Path(path)
    if path.exists():
        header = read_header(path)
        if header.case != case:
            raise ResultFileError(
                f"{path} holds another run than the one asked for; delete it or choose another folder. "
                f"There: {header.case}. Here: {case}"
            )
        if header.complete:
            if progress is not None:
                progress(1.0)
            return read_solution(path)
        start = Checkpoint(read_last_instant(path)) if header.n_times else None
        file = ResultFile.resume(path, case=case)
    else:
        path.parent.mkdir(parents=True, exist_ok=True)
        start = None
        file = ResultFile.create(path, case=case)
    with file:
        simulate(system, **options, resume=start, progress=progress, record=file.append)
        file.finish()
    return read_solution(path)
