"""Smaller bases for a sweep: the principal directions of the motions of its cases.

Rounds of self-correction append columns to a basis and remove none. Each column costs time in every case of a
sweep. Therefore the bases are reduced once more, to the principal directions of the motions of some cases in
the norm of the strain energy,

    gamma(t) = S c(t) + rest,   |L^T rest|_F <= a |L^T gamma|_F,   L L^T = V^T K V,

with the fewest columns V S; a is the smallest relative accuracy of these cases, or a tenth or a hundredth of
it. Stiff motion, such as that of a shell's membrane, is small, but without it the other motion locks; the
energy norm gives it weight. The same cases run again with these columns. The largest a is chosen for which no
case changes by more than a tenth of the allowed error.
Source: original to this project; a proper orthogonal decomposition of the motions in the energy norm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from supple.arrays import FloatArray
from supple.integrate import FloatingMotion
from supple.quantities.quantity_of_interest import WholeBody, quantity_distance
from supple.reduction import ReducedBody
from supple.simulation.stored_basis import stored_bases
from supple.sweeps.swept_group import SweptGroup, TrainingRuns

Bounds = dict[str, list[tuple[float, float]]]
"""Allowed error and largest displacement in each case, by body."""

SHARE = 0.1
"""Largest change of motion due to smaller bases, as a fraction of the allowed error; above it, the next
value of `MISSED` is tried."""
MISSED = (1.0, 0.1, 0.01)
"""Values of a that are tried in this order, as fractions of the smallest relative accuracy."""
LOOKED = 500
"""Runs with at least twice this number of output times are compared at every second, third, .. time only.

This number of times suffices to check a tenth of the allowed error.
"""
SOFTEST = 1e-7
"""Ratio of lowest to highest frequency of a basis up to which the body has a mechanism; its basis stays."""


def principal_directions(coordinates: FloatArray, stiffness: FloatArray, missed: float) -> FloatArray:
    """Fewest orthonormal directions S (r, p) of some motions, for a given error in the energy norm.

    coordinates : (t, r)
    stiffness : (r, r)  at rest, positive definite
    missed : largest energy norm of the motion outside S, as a fraction of that of the whole motion
    """
    factor = np.linalg.cholesky((stiffness + stiffness.T) / 2)
    _, lengths, rows = np.linalg.svd(coordinates @ factor, full_matrices=False)
    left = np.sqrt(np.cumsum(lengths[::-1] ** 2)[::-1])
    number = max(int(np.sum(left > missed * left[0])), 1)
    return np.linalg.qr(np.linalg.solve(factor.T, rows[:number].T))[0]


def with_principal_bases(group: SweptGroup, numbers: Sequence[int]) -> tuple[SweptGroup, TrainingRuns]:
    """The group with smaller bases, or the given group if motions change too much, and its training runs.

    numbers : numbers of the cases whose motions give the directions
    Raises errors as for `SweptGroup.training_runs`.
    """
    before = group.training_runs(numbers)
    bounds = _bounds(group, before)
    for missed in MISSED if before.cases and bounds else ():
        fewer = _fewer(group, before, bounds, missed)
        if not fewer:
            break
        reduced = group.with_bodies(fewer)
        after = reduced.training_runs(before.numbers)
        if _agree(before, after, bounds):
            return reduced, after
    return group, before


def _fewer(group: SweptGroup, runs: TrainingRuns, bounds: Bounds, missed: float) -> dict[str, ReducedBody]:
    """Bodies with a smaller basis, if their motions allow one; missed : fraction of the accuracy."""
    found = {}
    for name, basis in stored_bases(runs.cases[0].system, group.fulls(group.like)).items():
        if name not in bounds:
            continue
        body = group.bodies.reduced[name]
        coordinates = [solution.motion(name, FloatingMotion).coordinates for solution in runs.solutions]
        smallest = min(allowed / size if size else np.inf for allowed, size in bounds[name])
        # A body at rest gives no direction; a body with a mechanism has motion without energy.
        if not smallest < 1 or not body.frequencies.min() > SOFTEST * body.frequencies.max():
            continue
        directions = principal_directions(np.concatenate(coordinates), body.stiffness, missed * smallest)
        if directions.shape[1] < basis.r:
            found[name] = group.projected(name, replace(basis, vectors=basis.vectors @ directions))
    return found


def _agree(before: TrainingRuns, after: TrainingRuns, bounds: Bounds) -> bool:
    """Whether all cases run again, and their motions agree with the earlier motions."""
    if after.numbers != before.numbers:
        return False
    for name, limits in bounds.items():
        runs = zip(before.cases, before.solutions, after.cases, after.solutions, strict=True)
        for (one, solution, other, again), (allowed, _) in zip(runs, limits, strict=True):
            looked = slice(None, None, max(1, len(solution.times) // LOOKED))
            moved = quantity_distance(
                WholeBody(name), one.system, solution.at(looked), other.system, again.at(looked)
            )
            if not moved <= SHARE * allowed:
                return False
    return True


def _bounds(group: SweptGroup, runs: TrainingRuns) -> Bounds:
    """Bounds of the bodies whose bases must meet an accuracy of positions."""
    found: Bounds = {}
    for name, target in group.targets.items():
        if target.of is not None:
            continue
        motions = zip(runs.cases, runs.solutions, strict=True)
        sizes = [WholeBody(name).size(case.system, solution) for case, solution in motions]
        found[name] = [(target.allowed(size), size) for size in sizes]
    return found
