"""How far a sweep has come: from its folder alone, whoever runs it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from supple.storage.sealed_hdf5 import open_sealed
from supple.sweeps.attempts import Attempts
from supple.sweeps.part_file import CaseStatus, part_path, whole_parts
from supple.sweeps.plan import read_plan

__all__ = ["FailedCase", "SweepStatus", "sweep_status"]


@dataclass(frozen=True)
class FailedCase:
    """A case without results, and why."""

    case: int
    status: CaseStatus
    cause: str


@dataclass(frozen=True)
class SweepStatus:
    """Counts of cases and shares.

    missing : numbers of the shares without a whole part
    begun : of those, the ones that a process is at, or ended with
    failed : cases that were recorded without results
    warnings : of the runs, each once, with the number of shares that had it
    """

    n_cases: int
    n_shares: int
    n_ran: int
    missing: tuple[int, ...]
    begun: tuple[int, ...]
    failed: tuple[FailedCase, ...]
    warnings: tuple[tuple[str, int], ...] = ()

    @property
    def n_recorded(self) -> int:
        """Cases that are done, with results or a cause."""
        return self.n_ran + len(self.failed)

    @property
    def exit_code(self) -> int:
        """0 where all cases ran, 3 where all are recorded and some failed, 4 where some are missing."""
        if self.missing:
            return 4
        return 3 if self.failed else 0


def sweep_status(folder: Path | str) -> SweepStatus:
    """How far the sweep in a folder has come; ResultFileError where there is none."""
    folder = Path(folder)
    plan = read_plan(folder)
    whole = whole_parts(folder, plan.n_shares)
    missing = sorted(set(range(plan.n_shares)) - set(whole))
    n_ran, failed, warned = 0, list[FailedCase](), Counter[str]()
    for share in whole:
        with open_sealed(part_path(folder, share), verify=False) as file:
            status = file["status"][()]
            warned.update(file["warnings"].asstr()[()])
            n_ran += int((status == CaseStatus.RAN).sum())
            if (status != CaseStatus.RAN).any():
                rows = zip(file["cases"][()], status, file["cause"].asstr()[()], strict=True)
                failed += [FailedCase(int(case), CaseStatus(own), why) for case, own, why in rows if own]
    begun = tuple(share for share in missing if Attempts(folder, share).marks)
    failed.sort(key=lambda each: each.case)
    return SweepStatus(
        plan.n_cases, plan.n_shares, n_ran, tuple(missing), begun, tuple(failed), tuple(warned.items())
    )
