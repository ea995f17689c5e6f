"""Progress of a sweep, determined from its folder alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.sweeps.attempts import Attempts
from supple.sweeps.part_file import CaseStatus
from supple.sweeps.read_sweep import SweepColumns
from supple.units import with_unit

__all__ = ["CaseErrors", "FailedCase", "SweepStatus", "case_errors", "sweep_status"]


@dataclass(frozen=True)
class FailedCase:
    """A case without results, with the cause."""

    case: int
    status: CaseStatus
    cause: str


@dataclass(frozen=True)
class CaseErrors:
    """Summary of the estimated errors of the cases, lengths.

    n_estimated : number of cases with an estimate
    largest : largest estimate; NaN without estimates
    n_above : number of cases whose estimate exceeds the allowed error
    reasons : why cases have no estimate, with the number of cases of each reason
    """

    n_estimated: int = 0
    largest: float = np.nan
    n_above: int = 0
    reasons: Mapping[str, int] = field(default_factory=dict)

    def line(self, n_cases: int, n_again: int, unit: str) -> str:
        """One line on the estimates of a sweep of `n_cases` cases; `unit` is that of length."""
        largest = with_unit(f"{self.largest:.3g}", unit)
        above = f", {self.n_above} above their accuracy" if self.n_above else ""
        return (
            f"{self.n_estimated} of {n_cases} cases have an estimate, the largest is {largest}; "
            f"{n_again} run again{above}"
        )


@dataclass(frozen=True)
class SweepStatus:
    """Counts of cases and shares.

    n_again : number of cases that ran again with enriched bases, or must run again
    missing : numbers of the shares without a complete part
    begun : missing shares that a process runs, or whose process was killed
    failed : cases that are recorded without results
    warnings : warnings of the runs, each once, with the number of shares that had it
    """

    n_cases: int
    n_shares: int
    n_ran: int
    n_again: int
    missing: tuple[int, ...]
    begun: tuple[int, ...]
    failed: tuple[FailedCase, ...]
    warnings: tuple[tuple[str, int], ...] = ()
    errors: CaseErrors = field(default_factory=CaseErrors)

    @property
    def n_recorded(self) -> int:
        """Number of finished cases, with results or a cause."""
        return self.n_ran + len(self.failed)

    @property
    def exit_code(self) -> int:
        """0 if all cases ran, 3 if all are finished and some failed, 4 if some are missing."""
        if self.missing:
            return 4
        return 3 if self.failed else 0


def sweep_status(folder: Path | str) -> SweepStatus:
    """The progress of the sweep in a folder; ResultFileError if there is none."""
    folder = Path(folder)
    columns = SweepColumns(folder)
    shares = columns.shares
    own, warned = columns.all_of_cases("status", "cause", "no_estimate", "estimated_error", "allowed_error")
    failed = tuple(
        FailedCase(case, CaseStatus(own["status"][case]), own["cause"][case])
        for case in np.flatnonzero(own["status"] > 0).tolist()
    )
    return SweepStatus(
        columns.plan.n_cases,
        len(shares.cases),
        int((own["status"] == CaseStatus.RAN).sum()),
        len(shares.run_again),
        tuple(shares.missing),
        tuple(share for share in shares.missing if Attempts(folder, share).marks),
        failed,
        tuple(warned.items()),
        case_errors(own["estimated_error"], own["allowed_error"], own["no_estimate"]),
    )


def case_errors(estimated: FloatArray, allowed: FloatArray, reasons: NDArray[Any]) -> CaseErrors:
    """Summary of estimated errors, allowed errors and reasons without estimate, (n,) each.

    Unknown errors are NaN; the reason is "" for a case with an estimate.
    """
    known = ~np.isnan(estimated)
    above = estimated > allowed
    largest = float(estimated[known].max()) if known.any() else np.nan
    counts = Counter(reason for reason in reasons.tolist() if reason)
    return CaseErrors(int(known.sum()), largest, int(above.sum()), counts)
