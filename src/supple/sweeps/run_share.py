"""The task of a sweep: one process runs a share of the cases and writes one file."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

from supple.blas_threads import one_blas_thread
from supple.errors import ResultFileError, SuppleError, SuppleWarning
from supple.other_processes import one_core
from supple.storage.sealed_hdf5 import is_whole
from supple.sweeps.attempts import NOT_OF_A_CASE, Attempts
from supple.sweeps.certified_group import certified_group
from supple.sweeps.fatigue_loads import summed_spectra
from supple.sweeps.isolated_share import isolated_share
from supple.sweeps.march_cases import Began, march_cases
from supple.sweeps.part_file import CaseRecord, CaseStatus, Part, part_path, write_part
from supple.sweeps.plan import changed_inputs, read_plan
from supple.sweeps.sweep_shares import MOST_LEVELS, sweep_shares

__all__ = ["run_cases", "run_share"]


def run_share(folder: str, share: int, allow_code: bool = False) -> None:
    """Simulate the cases of a share and write their part, unless it exists already.

    Any process with access to the folder of the sweep and to the files of the case can run a share. All
    results are written to the folder. If two processes of a share were killed, isolated processes run its
    cases to find the cause (`isolated_share`).

    allow_code : run the Python file of `control`, if the case names one

    Raises
    ------
    ResultFileError         the part cannot be written; the inputs of the sweep were changed; meanwhile
                            another sweep was planned in the folder
    MemoryShortageError     not enough memory is left
    """
    where = Path(folder).resolve()
    target = part_path(where, share)
    if is_whole(target):
        return
    attempts, planned = Attempts(where, share), read_plan(where)
    cases, level = _cases_of(where, share)
    try:
        if attempts.are_many:
            part = isolated_share(where, cases, level, allow_code=allow_code)
        else:
            part = run_cases(where, cases, level, attempts.begin, allow_code=allow_code)
        if changed := changed_inputs(planned, read_plan(where)):
            raise ResultFileError(
                f"{where}: another sweep was planned here with --force while this one ran ({changed}); give "
                "each sweep its own folder"
            )
        write_part(target, part)
    except BaseException:
        attempts.withdraw()
        raise
    attempts.end()


def _cases_of(folder: Path, share: int) -> tuple[list[int], int]:
    """The cases of a share, and the number of their earlier runs."""
    plan = read_plan(folder)
    if share < plan.n_shares:
        return plan.cases_of(share).tolist(), 0
    shares = sweep_shares(folder, plan)
    if share >= len(shares.cases):
        raise ResultFileError(
            f"{folder} has no share {share} yet, because earlier shares are missing: run the sweep again"
        )
    return shares.cases[share].tolist(), shares.level[share]


def run_cases(
    folder: Path,
    cases: Sequence[int],
    level: int = 0,
    began: Began = lambda _: None,
    *,
    allow_code: bool = False,
) -> Part:
    """The results of cases of one group, simulated in this process.

    level : number of their earlier runs; repeated runs may have enriched bases
    began : marks the cases whose simulation begins; default: no mark, where the parent process gets the exit
        code
    """
    plan = read_plan(folder, allow_code=allow_code)
    number = int(plan.group[cases[0]])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", SuppleWarning)
        try:
            began(cases)
            # Other processes wait for the first certificate of a single group: their cores are free.
            with one_core() if level or plan.group.any() else nullcontext():
                group = certified_group(folder, plan, number, level, cases[0])
            if group.group.requests_errors and group.certificate.reason:
                warnings.warn(
                    f"errors of cases are not estimated: {group.certificate.reason}",
                    SuppleWarning,
                    stacklevel=1,
                )
            reason = group.certificate.why_no_estimate
            with one_core(), one_blas_thread():  # the other processes use the other cores
                results = [
                    replace(each, no_estimate=reason) if each.lacks_estimate else each
                    for each in march_cases(group, cases, began)
                ]
        except NOT_OF_A_CASE:
            raise
        except SuppleError as error:  # an error of the bodies, hence of all cases
            results = [CaseRecord(number, CaseStatus.FAILED, str(error)) for number in cases]
    words = dict.fromkeys(str(each.message) for each in caught if issubclass(each.category, SuppleWarning))
    # Cycles of cases that run again are counted after the last run.
    last = [each.spectrum for each in results if level == MOST_LEVELS or not each.needs_richer]
    return Part(results, tuple(words), plan.output.statistics, summed_spectra(last))
