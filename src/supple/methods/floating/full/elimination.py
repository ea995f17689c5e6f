"""Elimination of a full body's interior equations, for any load on them.

With the factored tangent `S`, the loads `r`, and the unknowns `u`, which are generalised interface forces,
accelerations of the frame and frame multipliers,

    x = - S^-1 r + Z u,       Z = - S^-1 [B^T, F, D^T]

with `F` the loads per acceleration of the frame. The interior acts on the machine by `L x`, `L = [E; B; D]`:
the forces on the frame, the motion of the interfaces, and the frame conditions. Vectors of the frame have
body components here, so that an elimination stays valid when the body has rotated.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from supple.algebra.low_rank_update import LowRankUpdate
from supple.algebra.sparse_factor import SparseFactor


class EliminatedInterior(NamedTuple):
    """An eliminated interior under its loads; forces and motions of the frame have global components."""

    part: slice
    """Numbers of the body's frame and interface motions in the border"""
    frame_residual: np.ndarray
    """(6,)"""
    frame_target: np.ndarray
    """Required values of the frame conditions, (6,)"""
    particular: np.ndarray
    """`- S^-1 r`, (n,)"""
    responses: np.ndarray
    """`Z`, (n, k), k = 6 p + 12, frame vectors in body components"""
    turn: np.ndarray
    """Map of unknowns with global components to unknowns with body components, (k, k)"""
    seen: np.ndarray
    """`L` times the particular part, (k,)"""
    seen_responses: np.ndarray
    """`L Z`, (k, k)"""
    frame_corner: np.ndarray
    """Frame equations per acceleration of the frame, (6, 6)"""

    def behind(self, unknowns: np.ndarray) -> np.ndarray:
        """`x` (n,) for unknowns (k,)."""
        return self.particular + self.responses @ (self.turn @ unknowns)


class Elimination(NamedTuple):
    """An eliminated interior, frame vectors in body components; built by `elimination`."""

    factor: SparseFactor | LowRankUpdate
    responses: np.ndarray
    """`Z`, (n, k)"""
    interface_rows: csr_array
    """`B`, (6 p, n)"""
    frame_rows: np.ndarray
    """`D`, (6, n)"""
    frame_equations: np.ndarray
    """`E`, (6, n)"""
    seen_responses: np.ndarray
    """`L Z`, (k, k)"""
    frame_corner: np.ndarray
    """(6, 6)"""

    def loaded(
        self, part: slice, residual: np.ndarray, frame_target: np.ndarray, rotation: np.ndarray
    ) -> EliminatedInterior:
        """The elimination under unbalanced forces (6 + n,), with the body's axes at a rotation (3, 3)."""
        particular = -self.factor.solve(residual[6:])
        p = self.responses.shape[1] - 12
        seen = _seen(self.frame_equations, self.interface_rows, self.frame_rows, particular)
        # Unknowns: interface forces, frame, multipliers. Rows: frame, interfaces, frame conditions.
        unknown, row, corner = np.eye(p + 12), np.eye(p + 12), np.eye(6)
        unknown[p : p + 3, p : p + 3] = rotation.T
        row[:3, :3] = corner[:3, :3] = rotation
        return EliminatedInterior(
            part,
            residual[:6],
            frame_target,
            particular,
            self.responses,
            unknown,
            row @ seen,
            row @ self.seen_responses @ unknown,
            corner @ self.frame_corner @ corner.T,
        )


def elimination(
    factor: SparseFactor | LowRankUpdate,
    responses: np.ndarray,
    interface_rows: csr_array,
    frame_rows: np.ndarray,
    frame_equations: np.ndarray,
    frame_corner: np.ndarray,
) -> Elimination:
    """The part of an elimination that does not depend on the loads."""
    seen = _seen(frame_equations, interface_rows, frame_rows, responses)
    return Elimination(factor, responses, interface_rows, frame_rows, frame_equations, seen, frame_corner)


def _seen(
    frame_equations: np.ndarray, interface_rows: csr_array, frame_rows: np.ndarray, motions: np.ndarray
) -> np.ndarray:
    return np.concatenate([frame_equations @ motions, interface_rows @ motions, frame_rows @ motions])
