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

from supple.methods.floating.full.elimination import LoadedElimination

__all__ = ["Border", "BorderedChange", "EliminatedInterior", "solve_bordered"]


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


class EliminatedInterior(NamedTuple):
    """The eliminated interior of one full body."""

    part: slice
    """Numbers of the body's frame and interface motions in the border"""
    out: LoadedElimination
    frame_residual: np.ndarray
    """(6,)"""
    frame_target: np.ndarray
    """Required values of the frame conditions, (6,)"""


class BorderedChange(NamedTuple):
    """Solution: changes of the border, the joint multipliers, and every interior."""

    border: np.ndarray
    multipliers: np.ndarray
    interiors: tuple[np.ndarray, ...]
    """(n_own,) each"""
    frame_multipliers: tuple[np.ndarray, ...]
    """(6,) each"""


def solve_bordered(border: Border, interiors: Sequence[EliminatedInterior]) -> BorderedChange:
    """Change of accelerations and multipliers that solves the bordered system."""
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
    return BorderedChange(
        border=solution[:n],
        multipliers=border.scale * solution[joints],
        interiors=tuple(
            _behind(interior, border, solution, joints, mu)
            for interior, mu in zip(interiors, frames, strict=True)
        ),
        frame_multipliers=tuple(solution[mu] for mu in frames),
    )


def _condense(interior: EliminatedInterior, mu: slice, matrix: np.ndarray, right: np.ndarray) -> None:
    """Replace the rows of one full body by those of its eliminated interior."""
    part, out = interior.part, interior.out
    frame, interface = slice(part.start, part.start + 6), slice(part.start + 6, part.stop)
    p = interface.stop - interface.start
    # Coupling `L x` of the interior per unknown; the border's rows of the interface are `c`.
    seen = out.seen_responses[:, :p] @ matrix[interface]
    seen[:, frame] += out.seen_responses[:, p : p + 6]
    seen[:, mu] += out.seen_responses[:, p + 6 :]
    matrix[frame] += seen[:6]
    matrix[frame, frame] += out.frame_corner
    right[frame] = -interior.frame_residual - out.seen[:6]
    matrix[interface] = seen[6 : 6 + p]
    matrix[interface, interface] -= np.eye(p)
    right[interface] = -out.seen[6 : 6 + p]
    matrix[mu] += seen[6 + p :]
    right[mu] = interior.frame_target - out.seen[6 + p :]


def _behind(
    interior: EliminatedInterior, border: Border, solution: np.ndarray, joints: slice, mu: slice
) -> np.ndarray:
    """Change of an interior's own accelerations, (n_own,)."""
    part, out = interior.part, interior.out
    interface = (border.matrix[part] @ solution[: len(border.matrix)])[6:]
    interface = interface + (border.rows.T[part] @ solution[joints])[6:] * border.scale
    return out.behind(np.concatenate([interface, solution[part][:6], solution[mu]]))
