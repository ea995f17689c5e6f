"""The bordered linear system of a step, its sparse interiors eliminated: a small dense one is left.

Unknown are the accelerations of frames, reduced and rigid bodies and interfaces (the border), the joint
multipliers, and per full body the six multipliers of its frame conditions. Behind the border an interior is

    x = particular + by_interface c + by_frame y + by_multiplier mu

with `c` the generalised interface forces, which are the border's own rows for the interface motions.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from supple.multibody.full.full_interior import Elimination

__all__ = ["Border", "BorderedChange", "EliminatedInterior", "solve_bordered"]


class Border(NamedTuple):
    """The compiled part of the system."""

    matrix: np.ndarray
    """(n, n)"""
    rows: np.ndarray
    """Constraint Jacobian, (m, n)"""
    rows_by_increment: np.ndarray
    """Likewise for the increments, (m, n)"""
    residual: np.ndarray
    """(n,)"""
    targets: np.ndarray
    """What the constraint rows must become, (m,)"""
    scale: float
    """Of multipliers, in parts of which they are of the size of accelerations"""


class EliminatedInterior(NamedTuple):
    """One full body behind its border."""

    part: slice
    """Its frame and interface motions in the border"""
    out: Elimination
    interface_rows: csr_array
    """(6 p, n_own)"""
    frame_rows: np.ndarray
    """Frame conditions, (6, n_own)"""
    frame_residual: np.ndarray
    """(6,)"""
    frame_target: np.ndarray
    """What the frame conditions must become, (6,)"""


class BorderedChange(NamedTuple):
    """The solution: of the border, the joint multipliers, and of every interior."""

    border: np.ndarray
    multipliers: np.ndarray
    interiors: tuple[np.ndarray, ...]
    """(n_own,) each"""
    frame_multipliers: tuple[np.ndarray, ...]
    """(6,) each"""


def solve_bordered(border: Border, interiors: Sequence[EliminatedInterior]) -> BorderedChange:
    """Solve for the change of accelerations and multipliers."""
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
    forces = matrix[interface].copy()  # generalised interface forces per unknown

    def through(left: np.ndarray | csr_array) -> tuple[np.ndarray, np.ndarray]:
        """Matrix and particular part of `left @ x` in terms of the unknowns."""
        total = (left @ out.by_interface) @ forces
        total[:, frame] += left @ out.by_frame
        total[:, mu] += left @ out.by_multiplier
        return total, left @ out.particular

    on_frame, particular = through(out.frame_rows)
    matrix[frame] += on_frame
    matrix[frame, frame] += out.frame_corner
    right[frame] = -interior.frame_residual - particular
    moved, particular = through(interior.interface_rows)
    matrix[interface] = moved
    matrix[interface, interface] -= np.eye(interface.stop - interface.start)
    right[interface] = -particular
    fixed, particular = through(interior.frame_rows)
    matrix[mu] += fixed
    right[mu] = interior.frame_target - particular


def _behind(
    interior: EliminatedInterior, border: Border, solution: np.ndarray, joints: slice, mu: slice
) -> np.ndarray:
    """Change of an interior's own accelerations, (n_own,)."""
    part, out = interior.part, interior.out
    interface = (border.matrix[part] @ solution[: len(border.matrix)])[6:]
    interface = interface + (border.rows.T[part] @ solution[joints])[6:] * border.scale
    by_frame = out.by_frame @ solution[part][:6]
    return out.particular + out.by_interface @ interface + by_frame + out.by_multiplier @ solution[mu]
