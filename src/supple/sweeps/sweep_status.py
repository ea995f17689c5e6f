"""Progress of a sweep, determined from its folder alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.storage.sealed_hdf5 import open_sealed
from supple.sweeps.attempts import Attempts
from supple.sweeps.part_file import CaseStatus, part_path
from supple.sweeps.plan import read_plan
from supple.sweeps.sweep_shares import sweep_shares
from supple.units import with_unit

__all__ = ["CaseErrors", "FailedCase", "SweepStatus", "case_errors", "sweep_status"]

Array = NDArray[np.float64]

_ERRORS = ("estimated_error", "allowed_error")


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
    plan = read_plan(folder)
    shares = sweep_shares(folder, plan)
    states = np.full(plan.n_cases, -1)
    errors = {name: np.full(plan.n_cases, np.nan) for name in _ERRORS}
    causes, warned = dict[int, str](), Counter[str]()
    reasons = np.full(plan.n_cases, "", dtype=object)
    for share in shares.whole:
        with open_sealed(part_path(folder, share), verify=False) as file:
            cases, own = file["cases"][()], file["status"][()]
            states[cases] = own
            warned.update(file["warnings"].asstr()[()])
            reasons[cases] = file["no_estimate"].asstr()[()]
            for name, own_errors in errors.items():
                own_errors[cases] = file[name][()]
            if (own != CaseStatus.RAN).any():
                causes |= dict(zip(cases.tolist(), file["cause"].asstr()[()], strict=True))
    failed = tuple(
        FailedCase(case, CaseStatus(states[case]), causes[case])
        for case in np.flatnonzero(states > 0).tolist()
    )
    begun = tuple(share for share in shares.missing if Attempts(folder, share).marks)
    return SweepStatus(
        plan.n_cases,
        len(shares.cases),
        int((states == CaseStatus.RAN).sum()),
        len(shares.run_again),
        tuple(shares.missing),
        begun,
        failed,
        tuple(warned.items()),
        case_errors(errors["estimated_error"], errors["allowed_error"], reasons),
    )


def case_errors(estimated: Array, allowed: Array, reasons: NDArray[Any]) -> CaseErrors:
    """Summary of estimated errors, allowed errors and reasons without estimate, (n,) each.

    Unknown errors are NaN; the reason is "" for a case with an estimate.
    """
    known = ~np.isnan(estimated)
    above = estimated > allowed
    largest = float(estimated[known].max()) if known.any() else np.nan
    counts = Counter(reason for reason in reasons.tolist() if reason)
    return CaseErrors(int(known.sum()), largest, int(above.sum()), counts)
