"""Compression of modal derivatives: the leading singular directions of the weighted derivatives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy import sparse

from supple.algebra import mass_orthonormalize
from supple.arguments import check_fields
from supple.body import FlexibleBody, Frame
from supple.reduction.bases.linear_basis import LinearBasis
from supple.reduction.derivatives.derivative_columns import DerivativeColumns, check_derivative_count
from supple.reduction.derivatives.modal_derivatives import ModalDerivatives, modal_derivatives
from supple.reduction.derivatives.pair_weights import AmplitudeProduct

__all__ = ["CompressedDerivatives", "LeadingDirections", "compress", "leading_directions"]

# Singular values below this fraction of the first are rounding errors.
ROUND_OFF = 1e-10


@dataclass(frozen=True)
class CompressedDerivatives:
    """Add n columns that contain the largest part of all weighted modal derivatives: the leading directions.

    The modal derivative of two columns is weighted by the expected product of their amplitudes.

    n : number of columns to add. If all derivatives span fewer dimensions, fewer columns are added, and the
        report lists the missing ones as dropped; for example, all derivatives of a straight beam in bending
        are axial
    weights : AmplitudeProduct(UnitLoad()) or AmplitudeProduct(StaticLoad(F))
    """

    n: int
    weights: AmplitudeProduct = field(default_factory=AmplitudeProduct)

    def __post_init__(self) -> None:
        check_fields(self)

    def columns(self, body: FlexibleBody, frame: Frame, basis: LinearBasis) -> DerivativeColumns:
        """Compressed columns, the leading one first; ModelError: fewer than n pairs, or a linear body."""
        check_derivative_count(self.n, len(basis.frequencies))
        derivatives = modal_derivatives(body, frame, basis)
        return compress(body, basis, derivatives, self.n, self.weights.weights(body, basis, derivatives))


def compress(
    body: FlexibleBody, basis: LinearBasis, derivatives: ModalDerivatives, n: int, weights: np.ndarray
) -> DerivativeColumns:
    """The n leading left singular vectors, in the M-norm, of weighted derivatives outside a basis, Z.

        Z = (I - X X^T M) [w_jk theta_jk] = Q R,   Q^T M Q = I,   R = U diag(s) W^T,   columns Q U_n

    Of all sets of n columns, these leave the smallest remainder of Z; the sum of its squared M-norms is
    sum_(i>n) s_i^2. Directions whose singular values are rounding errors are left out.
    """
    directions = leading_directions(
        derivatives.vectors * weights, basis.vectors, body.mass, derivatives.reference_norms(body) * weights
    )
    relative = directions.lengths / directions.lengths.max(initial=np.finfo(float).tiny)
    n_kept = min(n, int(np.count_nonzero(relative > ROUND_OFF)))
    missing = (
        f"compressed derivatives {n_kept + 1} to {n} (all derivatives lie in {n_kept} directions; the "
        f"remainder is below {ROUND_OFF:.0e} of the first direction)"
    )
    return DerivativeColumns(
        directions.vectors[:, :n_kept],
        labels=tuple(f"compressed derivative {i + 1}" for i in range(n_kept)),
        dropped=() if n_kept == n else (missing,),
        singular_values_kept=relative[:n_kept],
        singular_values_dropped=relative[n_kept:],
    )


class LeadingDirections(NamedTuple):
    """Directions in descending order of singular value."""

    vectors: np.ndarray
    """(n, k), M-orthonormal to each other and to the basis"""
    lengths: np.ndarray
    """(k,) singular values s: s_i^2 is the sum of the squared components of all fields along direction i"""


def leading_directions(
    fields: np.ndarray, basis: np.ndarray, mass: sparse.csc_array, reference_norms: np.ndarray
) -> LeadingDirections:
    """Left singular vectors, in the M-norm, of the parts Z of fields outside a basis.

        Z = (I - X X^T M) fields = Q R,   Q^T M Q = I,   R = U diag(s) W^T,   directions Q U

    Of all sets of k directions, the first k leave the smallest remainder of Z; the sum of its squared M-norms
    is sum_(i>k) s_i^2.

    fields : (n, m)
    basis : (n, r)              X, M-orthonormal
    reference_norms : (m,)      M-norms of the fields. A column of Z adds no direction if it is very small
                                relative to this norm, or depends on earlier columns
    """
    outside = fields - basis @ (basis.T @ (mass @ fields))
    r = basis.shape[1]
    together = mass_orthonormalize(
        np.hstack([basis, outside]), mass, reference_norms=np.concatenate([np.ones(r), reference_norms])
    )
    Q = together.vectors[:, r:]
    U, lengths, _ = np.linalg.svd(Q.T @ (mass @ outside), full_matrices=False)
    return LeadingDirections(Q @ U, lengths)
