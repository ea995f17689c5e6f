"""`supple sweep`: run the cases of a table, and print the progress of a sweep."""

from __future__ import annotations

from pathlib import Path

import typer

from supple.cli.computed_case import stated_interruption
from supple.errors import ArgumentError
from supple.sweeps import (
    Cluster,
    Executors,
    LocalProcesses,
    MpiProcesses,
    SweepStatus,
    make_plan,
    plan_sweep,
    read_sweep_file,
    run_part_of_sweep,
    run_sweep,
    sweep_status,
    write_sweep_report,
)
from supple.sweeps.part_file import CaseStatus
from supple.sweeps.plan import read_plan
from supple.terminal import bar, print_table, progress_bars, say

_MOST_SHOWN = 10
_BUT = {False: "", True: " without --force"}
_WORDS = {CaseStatus.FAILED: "failed", CaseStatus.KILLED: "killed its process"}


def chosen_executors(workers: int | None, cluster: str | None, mpi: bool, share: str | None) -> Executors:
    """The executors of the tasks; ArgumentError for more than one kind, or for a share, which has none."""
    kinds = sum([workers is not None, cluster is not None, mpi])
    if kinds > 1:
        raise ArgumentError("--workers, --cluster and --mpi are alternatives: give one of them")
    if kinds and share is not None:
        raise ArgumentError(
            "--share runs its cases one after the other in this process, without --workers, --cluster and "
            "--mpi: give one of them"
        )
    if cluster is not None:
        return Cluster(cluster)
    return MpiProcesses() if mpi else LocalProcesses(workers)


def share_of(text: str) -> tuple[int, int]:
    """The number of a job and the number of all jobs, from "K/N"; ArgumentError for another text."""
    try:
        number, of = map(int, text.split("/"))
    except ValueError:
        number, of = 0, 0
    if not 1 <= number <= of:
        raise ArgumentError(f"--share must be K/N, such as 3/40 (job 3 of 40); got {text}")
    return number, of


def sweep_cases(
    path: Path,
    folder: Path,
    executors: Executors,
    share: str | None,
    *,
    force: bool,
    allow_code: bool,
) -> None:
    """Run the unfinished cases of a sweep file; exit with the code of its `SweepStatus`.

    share : "K/N": only the part of job K of N, in this process, without the executors. While parts of other
        jobs are missing, the exit code is 0

    If interrupted by Ctrl-C (SIGINT) or the system (SIGTERM), print what is done, and exit with 130 or 143.
    """
    rest = f"{folder} has the finished cases; the same command{_BUT[force]} runs the rest"
    with stated_interruption(lambda _: rest):
        status = _run(path, folder, executors, share, force=force, allow_code=allow_code)
    if not status.missing:
        write_sweep_report(folder)
    _print(status, folder)
    if share is None or not status.missing:
        raise typer.Exit(status.exit_code)


def _run(
    path: Path, folder: Path, executors: Executors, share: str | None, *, force: bool, allow_code: bool
) -> SweepStatus:
    job = None if share is None else share_of(share)
    if job is not None and force:
        raise ArgumentError(
            "--force deletes the results of all jobs, and --share runs a single job: delete the folder once "
            f"({folder}), then start all jobs without --force"
        )
    given = read_sweep_file(path)
    plan = make_plan(given.case, given.table, given.output, allow_code=allow_code)
    plan_sweep(plan, folder, force=force)
    groups = "one group" if not plan.group.any() else f"{plan.group.max() + 1} groups"
    say(f"{plan.n_cases} cases in {plan.n_shares} shares, {groups} of bodies and runs")
    bars = progress_bars()
    with bars:
        report = bar(bars, "simulating cases")
        if job is None:
            return run_sweep(folder, executors, report, allow_code=allow_code)
        run_part_of_sweep(folder, *job, report, allow_code=allow_code)
    return sweep_status(folder)


def write_pages(folder: Path, n_reports: int, *, allow_code: bool) -> None:
    """Write the page of the sweep in a folder, and the reports of the cases with the most extremes."""
    bars = progress_bars()
    with bars:
        path = write_sweep_report(
            folder, n_reports, allow_code=allow_code, progress=bar(bars, "writing the page")
        )
    say(f"The page is {path}")


def print_status(folder: Path) -> None:
    """Print the progress of the sweep in a folder; exit with 3 or 4 as in `SweepStatus`."""
    status = sweep_status(folder)
    _print(status, folder)
    raise typer.Exit(status.exit_code)


def _print(status: SweepStatus, folder: Path) -> None:
    for text, number in status.warnings:
        shares = "" if number == 1 else f" ({number} shares)"
        say(f"warning: {text}{shares}")
    if status.failed:
        rows = [(str(each.case), _WORDS[each.status], each.cause) for each in status.failed[:_MOST_SHOWN]]
        print_table("Cases without results", ("case", "what", "cause"), rows)
        if len(status.failed) > _MOST_SHOWN:
            say(f"and {len(status.failed) - _MOST_SHOWN} more, with their causes in read_sweep(..).cause")
    killed = sum(each.status is CaseStatus.KILLED for each in status.failed)
    say(
        f"{status.n_cases} cases: {status.n_ran} ran, {len(status.failed) - killed} failed, "
        f"{killed} killed their process, {status.n_cases - status.n_recorded} to do"
        + (f"; {len(status.begun)} shares begun" if status.begun else "")
    )
    errors = status.errors
    if errors.n_estimated:
        say(errors.line(status.n_cases, status.n_again, read_plan(folder).units.length))
    for reason, number in errors.reasons.items():
        say(f"The errors of {number} cases are not estimated: {reason}")
    say(f"Results are in {folder}/")
