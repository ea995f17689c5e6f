"""The leading directions of a set of displacement fields outside a basis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse

from supple.algebra import mass_orthonormalize

__all__ = ["LeadingDirections", "leading_directions"]


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
