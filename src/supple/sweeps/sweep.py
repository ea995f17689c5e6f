"""Run of a sweep: plan it once, then run the missing shares on any executor."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from pathlib import Path
from typing import Any

import numpy as np

from supple.errors import CaseError, ResultFileError, SuppleError
from supple.importers.toml import checked
from supple.integrate import Progress
from supple.progress import by_fraction, with_progress_bar
from supple.storage.exclusive_lock import ExclusiveLock
from supple.storage.file_errors import file_errors
from supple.sweeps.attempts import Attempts
from supple.sweeps.case_table import CaseTable
from supple.sweeps.executors import Executors, Given, LocalProcesses
from supple.sweeps.fatigue_loads import FatigueLoads
from supple.sweeps.plan import SweepPlan, changed_inputs, make_plan, plan_path, read_plan, write_plan
from supple.sweeps.run_share import run_share
from supple.sweeps.sweep_file import SweepOutput
from supple.sweeps.sweep_shares import sweep_shares
from supple.sweeps.sweep_status import SweepStatus, sweep_status

__all__ = ["plan_sweep", "run_part_of_sweep", "run_sweep", "sweep"]

MOST_BREAKS_WITHOUT_PROGRESS = 2
"""Number of executors that break in succession without progress, after which the sweep fails."""


@with_progress_bar("sweep", by_fraction)
def sweep(
    case: Path | str,
    table: CaseTable | Mapping[str, Sequence[Any]],
    folder: Path | str,
    *,
    executor: Executor | None = None,
    keep: str | Sequence[int] = "none",
    fatigue: FatigueLoads | None = None,
    labels: Sequence[str] = (),
    seeds: Sequence[str] = (),
    force: bool = False,
    allow_code: bool = False,
    progress: Progress | None = None,
) -> SweepStatus:
    """Simulate a case file with many values; a repeated call runs only the cases that are still missing.

        sp.sweep("blade.toml", {"joint.shaft.law.speed": [1.0, 1.2, 1.4]}, "results/speeds")
        ds = sp.read_sweep("results/speeds")

    Parameters
    ----------
    table : a column of values for each path in the case file, a row for each case
    folder : for the plan, the reduced bodies and the parts of the sweep
    executor : runs the tasks; default: processes of this computer, one per core
    keep : cases whose motion is stored besides their statistics: "none", "all" or their numbers from 0
    fatigue : damage-equivalent loads and hot spots of the cases, and their lifetime
    labels : columns of the table that are no paths and change nothing, such as a wind speed
    seeds : columns whose values are realisations; the report has statistics over them
    force : discard the results in the folder and start again
    allow_code : run the Python file of `control`, if the case names one
    progress : called with the finished fraction of the cases

    Returns
    -------
    SweepStatus     a case that fails is recorded with its cause, and the sweep continues

    Raises
    ------
    CaseError           a path that does not exist, columns of different lengths; unknown channels, nodes,
                        labels, seeds or cases to keep
    ResultFileError     the folder has a sweep with other inputs, or cannot be written
    SuppleError         processes that end before they run a task: a script must call `sweep` under
                        `if __name__ == "__main__":`; a cluster that loses its scheduler
    """
    folder = Path(folder)
    table = table if isinstance(table, CaseTable) else CaseTable(table)
    kept = keep if isinstance(keep, str) else np.asarray(keep).tolist()
    output, mistakes = checked(
        SweepOutput, {"keep": kept, "fatigue": fatigue, "labels": list(labels), "seeds": list(seeds)}, []
    )
    if output is None:
        raise CaseError("sweep: " + "; ".join(f"{place[0]}: {message}" for place, message in mistakes))
    plan_sweep(make_plan(Path(case), table, output, allow_code=allow_code), folder, force=force)
    executors = LocalProcesses() if executor is None else Given(executor)
    return run_sweep(folder, executors, progress, allow_code=allow_code)


def plan_sweep(plan: SweepPlan, folder: Path, *, force: bool = False) -> None:
    """Write the plan of a sweep, unless the folder has the same plan already.

    force : replace an existing plan, and delete its results
    Raises ResultFileError if the folder has a sweep with other inputs, without `force`.
    """
    with file_errors("make the folder", folder):
        folder.mkdir(parents=True, exist_ok=True)
    with ExclusiveLock(folder, wait=True):
        if plan_path(folder).exists() and not force:
            changed = changed_inputs(read_plan(folder), plan)
            if changed:
                raise ResultFileError(
                    f"{folder} holds a sweep with other inputs ({changed}): replace it with --force, or "
                    "choose another folder with -o FOLDER"
                )
            return
        plan_path(folder).unlink(missing_ok=True)  # from now on, no process writes a part of the former sweep
        for name in ("sweep.html", "conditions.html"):  # of the former sweep
            (folder / name).unlink(missing_ok=True)
        for name in ("parts", "attempts", "cases", "certificates"):
            shutil.rmtree(folder / name, ignore_errors=True)
        write_plan(folder, plan)


def run_sweep(
    folder: Path, executors: Executors, progress: Progress | None = None, *, allow_code: bool = False
) -> SweepStatus:
    """Run the missing shares of the sweep in a folder.

    Parameters, results and errors as in `sweep`.
    """
    plan = read_plan(folder)
    shares = sweep_shares(folder, plan)
    done = set(shares.whole)
    missing = shares.missing

    def report() -> None:
        if progress is not None:
            progress(sum(len(shares.cases[share]) for share in done) / sum(map(len, shares.cases)))

    breaks = 0
    while missing:
        report()
        marks = _marks(folder, missing)
        before = len(done)
        errors: list[BaseException] = []
        with executors.opened() as executor:
            for share, error in _shares_run(executor, folder, missing, allow_code=allow_code):
                if error is None:
                    done.add(share)
                    report()
                elif isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker":  # of Dask
                    errors.append(error)  # a process was killed; the task did not raise it
                elif isinstance(error, CancelledError):
                    raise SuppleError(
                        "the tasks of the sweep were cancelled, usually because the cluster lost its "
                        f"scheduler; finished cases are in {folder}: the same command without force runs "
                        "the missing cases"
                    ) from error
                else:
                    raise error
        shares = sweep_shares(folder, plan)  # with the shares of cases that run again
        done, missing = set(shares.whole), shares.missing
        # A killed process leaves a mark, until isolated processes run its share.
        breaks = 0 if len(done) > before or _marks(folder, missing) > marks else breaks + 1
        if missing and breaks >= MOST_BREAKS_WITHOUT_PROGRESS:
            raise SuppleError(
                f"the processes of the sweep end before they run a task ({errors[-1]}): in a script, call "
                'sweep under if __name__ == "__main__":'
            ) from errors[-1]
    report()
    return sweep_status(folder)


def _marks(folder: Path, shares: Iterable[int]) -> int:
    return sum(len(Attempts(folder, share).marks) for share in shares)


def _shares_run(
    executor: Executor, folder: Path, shares: Sequence[int], *, allow_code: bool
) -> Iterable[tuple[int, BaseException | None]]:
    """Run shares; yields each when it ends, with its error or None."""
    tasks: dict[Future[None], int] = {}
    try:
        for share in shares:
            tasks[executor.submit(run_share, str(folder.resolve()), share, allow_code)] = share
    except BrokenExecutor as error:  # while tasks were submitted
        if not tasks:
            yield shares[0], error
    for task in as_completed(tasks):
        yield tasks[task], CancelledError() if task.cancelled() else task.exception()


def run_part_of_sweep(
    folder: Path, number: int, of: int, progress: Progress | None = None, *, allow_code: bool = False
) -> None:
    """Run, in this process, the shares of job k of n jobs of a sweep: k - 1, k - 1 + n, ...

    The job that ends last also repeats the cases that must run again with enriched bases.

    number : k, from 1;  of : n;  allow_code : as in `sweep`
    Raises errors as for `run_share`.
    """
    plan = read_plan(folder)
    shares = sweep_shares(folder, plan)
    own = list(range(number - 1, len(shares.cases), of))
    while own:
        for place, share in enumerate(own):
            run_share(str(folder), share, allow_code)
            if progress is not None:
                progress((place + 1) / len(own))
        known, shares = len(shares.cases), sweep_shares(folder, plan)
        # Only the job that ends last finds shares of cases that must run again.
        own = list(range(known, len(shares.cases)))
