"""Bases in fewer columns: the directions in which the cases of a sweep move.

Rounds of self-correction append columns and remove none. A thousand cases pay for each of them, so that
the bases are reduced once more, to the principal directions of the motions of some cases in the norm of the
strain energy,

    gamma(t) = S c(t) + rest,   |L^T rest|_F <= a |L^T gamma|_F,   L L^T = V^T K V,

with the fewest columns V S; a is the smallest relative accuracy of these cases, or a tenth or a hundredth of
it. The energy weighs stiff motion, such as that of a shell's membrane, which is small, and without which the
others lock. The same cases run again in these columns; the first a is taken with which no case moves by more
than a tenth of what is allowed.
Source: this project's own, a proper orthogonal decomposition of the motions in the energy norm.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from supple.errors import LockingWarning
from supple.integrate import FloatingMotion
from supple.quantities.quantity_of_interest import WholeBody, quantity_distance
from supple.reduction import ReducedBody, project
from supple.simulation.stored_basis import stored_bases
from supple.sweeps.swept_group import SweptGroup
from supple.sweeps.training_runs import TrainingRuns, training_runs

__all__ = ["in_leading_columns", "leading_directions"]

Array = NDArray[np.float64]

SHARE = 0.1
"""Of the allowed error: by so much a case may move where its bases have fewer columns."""
MISSED = (1.0, 0.1, 0.01)
"""Of the smallest relative accuracy: part of the motions that the columns may miss, one after the other."""
SOFTEST = 1e-7
"""Of the highest frequency of a basis: a lower one is none."""


def leading_directions(coordinates: Array, stiffness: Array, missed: float) -> Array:
    """Fewest orthonormal directions S (r, p) of motions, which miss no more than a part of their energy norm.

    coordinates : (t, r)
    stiffness : (r, r)  at rest, positive definite
    missed : of the norm of all instants together
    """
    factor = np.linalg.cholesky((stiffness + stiffness.T) / 2)
    _, lengths, rows = np.linalg.svd(coordinates @ factor, full_matrices=False)
    left = np.sqrt(np.cumsum(lengths[::-1] ** 2)[::-1])
    number = max(int(np.sum(left > missed * left[0])), 1)
    return np.linalg.qr(np.linalg.solve(factor.T, rows[:number].T))[0]


def in_leading_columns(group: SweptGroup, numbers: Sequence[int]) -> SweptGroup:
    """The group with bases of fewer columns; as it is where these would change the motion of its cases.

    numbers : of the cases that show the directions
    Raises errors as `training_runs`.
    """
    if not _names(group):
        return group
    before = training_runs(group, numbers)
    for missed in MISSED if before.cases else ():
        fewer = _fewer(group, before, missed)
        if not fewer:
            break
        reduced = group.with_bodies(fewer)
        if _agree(group, before, training_runs(reduced, before.numbers)):
            return reduced
    return group


def _fewer(group: SweptGroup, runs: TrainingRuns, missed: float) -> dict[str, ReducedBody]:
    """Bodies whose motions take fewer columns than they have; missed : of the accuracy."""
    like = group.like
    fulls = group.fulls(like)
    found = {}
    for name, basis in stored_bases(runs.cases[0].system, fulls).items():
        if name not in _names(group):
            continue
        body = group.bodies.reduced[name]
        coordinates = [solution.motion(name, FloatingMotion).coordinates for solution in runs.solutions]
        smallest = min(
            allowed / size if size else np.inf for allowed, size in _allowed_and_sizes(group, runs, name)
        )
        # A body that rests shows no direction, and one with a mechanism has motion without energy.
        if not smallest < 1 or not body.frequencies.min() > SOFTEST * body.frequencies.max():
            continue
        directions = leading_directions(np.concatenate(coordinates), body.stiffness, missed * smallest)
        if directions.shape[1] < basis.r:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", LockingWarning)
                found[name] = project(
                    fulls[name].body,
                    replace(basis, vectors=basis.vectors @ directions),
                    damping=fulls[name].damping,
                    quartic=group.fresh.starts[name].quartic,
                )
    return found


def _agree(group: SweptGroup, before: TrainingRuns, after: TrainingRuns) -> bool:
    """Whether all cases run, and move as before."""
    if after.numbers != before.numbers:
        return False
    for name in _names(group):
        runs = zip(before.cases, before.solutions, after.cases, after.solutions, strict=True)
        limits = [allowed for allowed, _ in _allowed_and_sizes(group, before, name)]
        for (one, solution, other, again), allowed in zip(runs, limits, strict=True):
            moved = quantity_distance(WholeBody(name), one.system, solution, other.system, again)
            if not moved <= SHARE * allowed:
                return False
    return True


def _names(group: SweptGroup) -> list[str]:
    """Bodies whose positions have an accuracy; of others the size or another quantity was asked for."""
    return [name for name, start in group.fresh.starts.items() if start.target.of is None]


def _allowed_and_sizes(group: SweptGroup, runs: TrainingRuns, name: str) -> list[tuple[float, float]]:
    """Of a body in each case: the error that it may have, and its largest displacement."""
    target = group.fresh.starts[name].target
    sizes = [
        WholeBody(name).size(case.system, solution)
        for case, solution in zip(runs.cases, runs.solutions, strict=True)
    ]
    return [(target.allowed(size), size) for size in sizes]
