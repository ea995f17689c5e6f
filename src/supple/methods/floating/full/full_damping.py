"""Damping of a full body: a sparse matrix, a low-rank product, and damping proportional to strain rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from supple.algebra.low_rank_update import LowRankUpdate
from supple.algebra.sparse_factor import SparseFactor
from supple.arrays import FloatArray
from supple.body import FlexibleBody, Frame, FullBody, ModalDamping, NodalFixedFrame


@dataclass(frozen=True, eq=False)
class FullDamping:
    """D(q) = C + W S W^T + beta K_mat(q) of one full body, for motion relative to its frame.

    constant : C, sparse (n, n)
    columns : W (n, m), of damped modes, or of mass-proportional damping relative to an interface
    signs : diagonal of S, (m,), each 1 or -1
    retardation_time : beta, s; 0 without damping by strain rate
    """

    full: FullBody
    constant: csc_array
    columns: FloatArray
    signs: FloatArray
    retardation_time: float

    def force(self, rates: FloatArray) -> FloatArray:
        """(C + W S W^T) q_dot, (n,); the elastic force includes the damping by strain rate."""
        return self.constant @ rates + self.columns @ (self.signs * (self.columns.T @ rates))

    def with_modes(self, factor: SparseFactor, by_velocity: float) -> SparseFactor | LowRankUpdate:
        """The factor of a tangent without W S W^T, updated by that term."""
        if not (by_velocity and self.columns.size):
            return factor
        return LowRankUpdate(factor, self.columns, by_velocity * self.signs)


def full_damping(full: FullBody) -> FullDamping:
    """Damping of a full body by its damping option; ModelError for an option that does not fit the body."""
    body, damping = full.body, full.damping
    none, no_columns = csc_array(body.mass.shape), np.empty((body.n, 0))
    own = none if body.damping is None else body.damping
    if damping is None:
        return FullDamping(full, own, no_columns, np.empty(0), 0.0)
    held: Frame = full.frame if damping.held is None else NodalFixedFrame(damping.held)
    if isinstance(damping, ModalDamping):
        columns = damping.columns(body.stiffness, body.mass, held.constraint(body))
        if held != full.frame:
            columns = columns - _interface_motion(body, held).T @ (body.rigid_modes.T @ columns)
        return FullDamping(full, own, columns, np.ones(columns.shape[1]), 0.0)
    time = 0.0 if body.is_linear else damping.retardation_time
    constant = csc_array(damping.matrix(none if time else body.stiffness, body.mass) + own)
    if held == full.frame or not damping.alpha:
        return FullDamping(full, constant, no_columns, np.empty(0), time)
    columns = np.sqrt(damping.alpha) * _seen_from(body, held)
    return FullDamping(full, constant, columns, np.repeat([1.0, -1.0], 6), time)


def _interface_motion(body: FlexibleBody, held: Frame) -> FloatArray:
    """G (6, n), rigid motion of an interface: G R = I."""
    motion = held.constraint(body)
    return np.asarray(np.linalg.solve(motion @ body.rigid_modes, motion), dtype=np.float64)


def _seen_from(body: FlexibleBody, held: Frame) -> FloatArray:
    """Columns [W, U], (n, 12), of P^T M P - M = W W^T - U U^T, with P = I - R G.

    U = M R L^-T and W = U - G^T L, with R^T M R = L L^T.
    """
    R = body.rigid_modes
    momenta = body.mass @ R
    lower = np.linalg.cholesky(R.T @ momenta)
    rigid = np.linalg.solve(lower, momenta.T).T
    beside = rigid - _interface_motion(body, held).T @ lower
    return np.asarray(np.hstack([beside, rigid]), dtype=np.float64)
