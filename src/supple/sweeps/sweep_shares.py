"""The shares of a sweep: those of its plan, and those of cases that run again, with enriched bases if needed.

The cases that run again are determined from the stored parts only. Therefore every process finds the same
cases, also after an interruption.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from supple.arrays import IntArray
from supple.storage.sealed_hdf5 import open_sealed
from supple.sweeps.part_file import CaseStatus, part_path, whole_parts
from supple.sweeps.plan import SweepPlan

MOST_LEVELS = 2
"""Largest number of repeated runs of a case."""

CERTIFIED_ALONE = 3
"""Largest number of repeated cases of a group with one certificate each, computed in parallel. One common
certificate would need about as many full estimates, one after the other."""


@dataclass(frozen=True, eq=False)
class SweepShares:
    """All shares that the existing parts determine.

    cases : cases of each share, ascending
    level : number of earlier runs of the cases of each share
    whole : shares whose parts are complete
    """

    plan: SweepPlan
    cases: Sequence[IntArray]
    level: Sequence[int]
    whole: Sequence[int]

    @property
    def missing(self) -> list[int]:
        """Shares without a complete part."""
        return sorted(set(range(len(self.cases))) - set(self.whole))

    @property
    def run_again(self) -> IntArray:
        """Cases that have run again, or must run again."""
        own = [cases for cases, level in zip(self.cases, self.level, strict=True) if level]
        return np.unique(np.concatenate(own)) if own else np.zeros(0, dtype=np.int64)

    def level_of(self, case: int) -> int:
        """Level of the last complete run of a case; 0 if there is none."""
        return max((self.level[share] for share in self.whole if case in self.cases[share]), default=0)

    def is_certified_alone(self, case: int, level: int) -> bool:
        """Whether a case that runs again at a level has a certificate for this case alone."""
        return 0 < len(self.cases_of_level(level, int(self.plan.group[case]))) <= CERTIFIED_ALONE

    def cases_of_level(self, level: int, group: int) -> list[int]:
        """Cases of a group that run at a level."""
        own = [cases for cases, each in zip(self.cases, self.level, strict=True) if each == level]
        found = np.concatenate([np.zeros(0, dtype=np.int64), *own])
        return sorted(found[self.plan.group[found] == group].tolist())


def sweep_shares(folder: Path, plan: SweepPlan) -> SweepShares:
    """The shares of the sweep in a folder, as far as the existing parts determine them."""
    cases = [plan.cases_of(share) for share in range(plan.n_shares)]
    levels = [0] * len(cases)
    whole = whole_parts(folder, len(cases))
    size = max(len(each) for each in cases)
    first = 0
    for level in range(1, MOST_LEVELS + 1):
        if len(whole) < len(cases):
            break
        again = _exceeding(folder, range(first, len(cases)))
        first = len(cases)
        for group in np.unique(plan.group[again]):
            own = again[plan.group[again] == group]
            more = np.array_split(own, len(own) if len(own) <= CERTIFIED_ALONE else -(-len(own) // size))
            cases += more
            levels += [level] * len(more)
        whole = whole_parts(folder, len(cases))
        if first == len(cases):
            break
    return SweepShares(plan, cases, levels, whole)


def largest_ratio(folder: Path, shares: SweepShares, cases: Sequence[int], level: int) -> int:
    """The case of `cases` with the largest ratio of basis error to allowed error in its run at a level."""
    ratios = dict.fromkeys(cases, 0.0)
    for share, own in enumerate(shares.level):
        if own == level:
            with open_sealed(part_path(folder, share), verify=False) as file:
                found = file["basis_error"][()] / file["allowed_error"][()]
                ratios |= {
                    case: ratio
                    for case, ratio in zip(file["cases"][()].tolist(), found.tolist(), strict=True)
                    if case in ratios
                }
    return max(cases, key=lambda case: (ratios[case], -case))


def _exceeding(folder: Path, shares: range) -> IntArray:
    """Cases of some shares whose basis error exceeds the allowed error, ascending."""
    found = [np.zeros(0, dtype=np.int64)]
    for share in shares:
        with open_sealed(part_path(folder, share), verify=False) as file:
            ran = file["status"][()] == CaseStatus.RAN
            exceeds = file["basis_error"][()] > file["allowed_error"][()]
            found.append(file["cases"][()][ran & exceeds])
    return np.unique(np.concatenate(found))
