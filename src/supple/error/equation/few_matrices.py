"""Weighted sums of many constant matrices along runs, from few combinations of the matrices.

A tangent along a run is a sum of about a hundred matrices with weights at every step. A blade bends in few
shapes in all runs, so that few combinations of these matrices give all tangents.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from supple.arrays import FloatArray

ROUND_OFF = 1e-14
"""Ratio to the largest eigenvalue of the Gram matrix below which an eigenvalue is round-off."""


class FewMatrices(NamedTuple):
    """For each set, q matrices (q, k, k); and their weights along the runs (t, q)."""

    sets: tuple[FloatArray, ...]
    weights: FloatArray


def few_matrices(
    sets: Sequence[FloatArray], weights: FloatArray, unit: FloatArray, missed: float
) -> FewMatrices:
    """The fewest leading combinations of matrices that give the sums along runs to the allowed error.

        sum_i w_i(t) S_i = sum_q w'_q(t) S'_q + R(t),    |U^T R U|_F <= missed   at every step

    The combinations are the principal directions of `w(t)` in the norm of the sums of all sets,
    `|sum_i w_i U^T S_i U|_F`.

    sets : (m, k, k) each, which share their weights (t, m)
    unit : (k, k) U, in which the stiffness at rest is the unit matrix
    missed : the allowed error, relative to that stiffness
    """
    # Weighted by the largest contribution: the size of a matrix with zero weight does not count.
    scale = np.abs(weights).max(axis=0, initial=0.0)
    scaled = np.hstack([(unit.T @ own @ unit).reshape(len(own), -1) for own in sets]) * scale[:, None]
    squares, vectors = np.linalg.eigh(scaled @ scaled.T)
    known = squares > ROUND_OFF * squares[-1]
    lengths, vectors = np.sqrt(squares[known]), vectors[:, known]
    # The sums in orthonormal directions of the space of matrices, (t, n); then in their principal axes.
    sums = (weights / np.where(scale > 0, scale, 1.0)) @ (vectors * lengths)
    axes = np.linalg.eigh(sums.T @ sums)[1][:, ::-1]
    along = sums @ axes
    left = np.cumsum(along[:, ::-1] ** 2, axis=1)[:, ::-1].max(axis=0, initial=0.0)
    number = int(np.sum(left > missed**2))
    combined = (axes[:, :number].T / lengths) @ (vectors.T * scale)
    return FewMatrices(tuple(np.tensordot(combined, own, axes=1) for own in sets), along[:, :number])
