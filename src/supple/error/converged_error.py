"""Errors that are not small: Newton iterations of the error equation about the corrected motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from supple.error.basis_error import FIRST_ORDER
from supple.error.equation import ErrorEquation, ErrorHistory, TangentMotion
from supple.error.equation.linearised_march import ErrorState
from supple.error.stopping import locks
from supple.reduction import ReducedBody

SMALL_SECOND = 0.1
"""Ratio of the second correction to the first, below which the first-order error is accepted. For struck
plates and strips, the converged error differs from the first order by a third to a tenth of this ratio."""
SMALL_SECOND_LOCKED = 0.02
"""`SMALL_SECOND` for bodies that lock: their converged error can differ by twice this ratio."""
SMALL_CHANGE = 0.02
"""Largest relative change in the last iteration of large errors and of errors with kinks."""
SWEEPS = 3
"""Largest number of iterations about the corrected motion."""
SMALL_TURN = 0.02
"""Error of a frame's rotation, rad, that counts as small."""
DEFORMED = 8
"""Number of steps besides the first at which the deformation of a run is sampled."""

Differences = tuple[ErrorState, Mapping[str, ErrorHistory], dict[str, float]]
"""True motion less the run's motion; the errors and their last relative change, both by body."""


def converged(
    equation: ErrorEquation,
    first: ErrorState,
    histories: Mapping[str, ErrorHistory],
    tangents: TangentMotion | None = None,
    *,
    smooth: bool = True,
) -> Differences:
    """Iterate the error equation about the corrected motion until the differences converge.

    Each iteration is a Newton step for the motion itself. Without convergence the first differences are
    returned, as an order of magnitude. The iteration continues until the change is at most `SMALL_CHANGE`
    instead of `FIRST_ORDER` in two cases: where forces have kinks (a small change can be an oscillation
    between two sides of a kink), and for large errors (`is_large`).

    tangents : as for `ErrorEquation.first`
    smooth : bool   whether forces have no kinks
    """
    found, own, changes = first, histories, dict.fromkeys(histories, np.inf)
    if not is_finite(histories):
        return found, own, changes
    for _ in range(SWEEPS):
        more = equation.again(found, tangents)
        again = equation.histories(more)
        changes = {name: _change(own[name], each) for name, each in again.items()}
        if not np.isfinite(max(changes.values())):
            break
        found, own = more, again
        near = smooth and not any(map(is_large, own.values()))
        if max(changes.values()) <= (FIRST_ORDER if near else SMALL_CHANGE):
            break
    if any(map(is_large, own.values())) and max(changes.values()) > SMALL_CHANGE:
        changes = dict.fromkeys(histories, np.inf)  # a march that diverges slowly changes little each time
    if max(changes.values()) <= FIRST_ORDER:
        return found, own, changes
    return first, histories, changes


def is_finite(histories: Mapping[str, ErrorHistory]) -> bool:
    """Whether the errors are finite at every step."""
    return all(bool(np.isfinite(history.rms).all()) for history in histories.values())


def is_small(
    histories: Mapping[str, ErrorHistory], second: Mapping[str, float], reduced: Mapping[str, ReducedBody]
) -> bool:
    """Whether errors are small: second corrections, frame rotations, and size relative to the deformation.

    reduced : the assessed bodies as simulated
    """
    limit = SMALL_SECOND_LOCKED if any(map(locks, reduced.values())) else SMALL_SECOND
    small = max(second.values()) <= limit and _largest_turn(histories) <= SMALL_TURN
    return small and not any(map(is_large, histories.values()))


def deformed_rows(n_steps: int) -> np.ndarray:
    """Indices of the steps of a run at which its deformation is sampled, including the first."""
    return np.unique(np.linspace(0, n_steps - 1, DEFORMED + 1).round().astype(int))


def deflection(history: ErrorHistory) -> float:
    """Largest RMS over the nodes of the deformation in the run itself."""
    motion = history.body.motion
    rows = deformed_rows(len(motion.coordinates))
    fields = history.body.full.expand(motion.vectors.T)
    deformed = np.tensordot(motion.coordinates[rows], fields, axes=1)
    return float(np.sqrt(np.mean(np.sum(deformed**2, axis=2), axis=1)).max(initial=0.0))


def is_large(history: ErrorHistory) -> bool:
    """Whether an error exceeds a third of the deformation.

    Then a small second correction is no proof of accuracy, because the linearised march may have diverged.
    Converged iterations are a proof, in columns that contain the motion outside the basis.
    """
    return bool(history.rms.max() > FIRST_ORDER * deflection(history))


def _largest_turn(histories: Mapping[str, ErrorHistory]) -> float:
    """Largest error of the frames' rotations, rad."""
    return max(float(np.abs(history.turn).max()) for history in histories.values())


def _change(first: ErrorHistory, again: ErrorHistory) -> float:
    """Difference (RMS over nodes) of two estimates at the times of their maxima, relative to the first."""
    if not np.isfinite(again.rms).all():
        return np.inf
    rows = np.unique([int(np.argmax(first.rms)), int(np.argmax(again.rms))])
    apart = max(
        float(np.sqrt(np.mean(np.sum((first.at_nodes(row) - again.at_nodes(row)) ** 2, axis=1))))
        for row in rows
    )
    return apart / max(float(first.rms.max()), np.finfo(float).tiny)
