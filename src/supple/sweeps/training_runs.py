"""Training runs: simulations of some cases of a group before the group runs."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from supple.cases.notify import silent
from supple.errors import CaseError, ConvergenceError
from supple.integrate import Solution
from supple.simulation import simulate_batch
from supple.sweeps.swept_group import SweptCase, SweptGroup

__all__ = ["TrainingRuns", "training_runs"]


@dataclass(frozen=True, eq=False)
class TrainingRuns:
    """Numbers, machines and solutions of the cases that ran to their end."""

    numbers: Sequence[int]
    cases: Sequence[SweptCase]
    solutions: Sequence[Solution]


def training_runs(group: SweptGroup, numbers: Sequence[int]) -> TrainingRuns:
    """Simulate cases of a group in one batch; cases that fail are left out.

    The failure is recorded later, when the sweep runs the case. Raises CaseError if no machine can be built;
    errors of `simulate_batch`.
    """
    known, made = list[int](), list[SweptCase]()
    for number in numbers:
        with suppress(CaseError, ConvergenceError):
            made.append(group.case(number))
            known.append(number)
    if not made:
        raise CaseError("no machine of the group can be built: check the values of the table")
    found = simulate_batch([own.system for own in made], made[0].run, progress=silent)
    ran = [place for place in range(len(made)) if place not in found.failures]
    return TrainingRuns(
        [known[place] for place in ran],
        [made[place] for place in ran],
        [found.solutions[place] for place in ran],
    )
