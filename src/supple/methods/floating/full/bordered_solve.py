"""Solution of the bordered linear system of a step: sparse interiors are eliminated, the border is dense.

The unknowns are the accelerations of frames, reduced and rigid bodies and interfaces (the border), the joint
multipliers, and six multipliers of frame conditions per full body. The interior of a full body is

    x = particular + responses [c, y, mu]

with `c` the generalised interface forces (the border's equations for the interface motions), `y` the
accelerations of its frame and `mu` the multipliers of its frame conditions.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from supple.methods.floating.full.elimination import EliminatedInterior


class Border(NamedTuple):
    """The compiled part of the linear system."""

    matrix: np.ndarray
    """(n, n)"""
    rows: np.ndarray
    """Constraint Jacobian, (m, n)"""
    rows_by_increment: np.ndarray
    """Constraint Jacobian with respect to the increments, (m, n)"""
    residual: np.ndarray
    """(n,)"""
    targets: np.ndarray
    """Required values of the constraint rows, (m,)"""
    scale: float
    """Unit of the multipliers; in this unit they have the size of accelerations"""


def solve_bordered(
    border: Border, interiors: Sequence[EliminatedInterior]
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """Changes of the border and the joint multipliers; and of every interior and its frame multipliers."""
    n, m = len(border.matrix), len(border.targets)
    joints = slice(n, n + m)
    frames = [slice(n + m + 6 * number, n + m + 6 * number + 6) for number in range(len(interiors))]
    matrix = np.zeros((n + m + 6 * len(interiors), n + m + 6 * len(interiors)))
    right = np.zeros(len(matrix))
    matrix[:n, :n] = border.matrix
    matrix[:n, joints] = border.scale * border.rows.T
    matrix[joints, :n] = border.scale * border.rows_by_increment
    right[:n] = -border.residual
    right[joints] = border.scale * border.targets
    for interior, mu in zip(interiors, frames, strict=True):
        _condense(interior, mu, matrix, right)
    solution = np.linalg.solve(matrix, right)
    behind = (_behind(each, border, solution, joints, mu) for each, mu in zip(interiors, frames, strict=True))
    return solution[:n], border.scale * solution[joints], tuple(behind), tuple(solution[mu] for mu in frames)


def _condense(interior: EliminatedInterior, mu: slice, matrix: np.ndarray, right: np.ndarray) -> None:
    """Replace the rows of one full body by those of its eliminated interior."""
    part, seen_own = interior.part, interior.seen
    frame, interface = slice(part.start, part.start + 6), slice(part.start + 6, part.stop)
    p = interface.stop - interface.start
    # Coupling `L x` of the interior per unknown; the border's rows of the interface are `c`.
    seen = interior.seen_responses[:, :p] @ matrix[interface]
    seen[:, frame] += interior.seen_responses[:, p : p + 6]
    seen[:, mu] += interior.seen_responses[:, p + 6 :]
    matrix[frame] += seen[:6]
    matrix[frame, frame] += interior.frame_corner
    right[frame] = -interior.frame_residual - seen_own[:6]
    matrix[interface] = seen[6 : 6 + p]
    matrix[interface, interface] -= np.eye(p)
    right[interface] = -seen_own[6 : 6 + p]
    matrix[mu] += seen[6 + p :]
    right[mu] = interior.frame_target - seen_own[6 + p :]


def _behind(
    interior: EliminatedInterior, border: Border, solution: np.ndarray, joints: slice, mu: slice
) -> np.ndarray:
    """Change of an interior's own accelerations, (n_own,)."""
    part = interior.part
    interface = (border.matrix[part] @ solution[: len(border.matrix)])[6:]
    interface = interface + (border.rows.T[part] @ solution[joints])[6:] * border.scale
    return interior.behind(np.concatenate([interface, solution[part][:6], solution[mu]]))
