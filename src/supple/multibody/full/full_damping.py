"""Damping of a full body: a sparse matrix, a product of few columns, and what follows the strain rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from supple.algebra.low_rank_update import LowRankUpdate
from supple.algebra.sparse_factor import SparseFactor
from supple.body import FullBody, ModalDamping

__all__ = ["FullDamping", "full_damping"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FullDamping:
    """D(q) = C + W W^T + beta K_mat(q) of one full body, in motion against its frame.

    constant : C, sparse (n, n)
    columns : W (n, m), of the modes that are damped; m is 0 without
    retardation_time : beta, s; 0 without
    """

    full: FullBody
    constant: csc_array
    columns: Array
    retardation_time: float

    def force(self, rates: Array) -> Array:
        """(C + W W^T) q_dot, (n,); what follows the strain rate comes with the elastic force."""
        return self.constant @ rates + self.columns @ (self.columns.T @ rates)

    def with_modes(self, factor: SparseFactor, by_velocity: float) -> SparseFactor | LowRankUpdate:
        """The factor of a tangent that lacks W W^T, with it."""
        if not (by_velocity and self.columns.size):
            return factor
        return LowRankUpdate(factor, self.columns, by_velocity)


def full_damping(full: FullBody) -> FullDamping:
    """The damping of a full body, as its option says; ModelError for one that does not fit it."""
    body, damping = full.body, full.damping
    none, no_columns = csc_array(body.mass.shape), np.empty((body.n, 0))
    if damping is None:
        return FullDamping(full, none, no_columns, 0.0)
    if isinstance(damping, ModalDamping):
        columns = damping.columns(body.stiffness, body.mass, full.frame.constraint(body))
        return FullDamping(full, none, columns, 0.0)
    time = 0.0 if body.is_linear else damping.retardation_time
    constant = csc_array(damping.matrix(none if time else body.stiffness, body.mass))
    return FullDamping(full, constant, no_columns, time)
