"""Mass-orthonormal bases: rank-revealing Gram-Schmidt in the order of the columns."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.algebra.sparse_factor import Matrix
from supple.arrays import FloatArray
from supple.errors import AccuracyError, ModelError

__all__ = ["OrthonormalBasis", "mass_orthonormalize"]

LARGEST_GRAM_ERROR = 1e-10
"""Allowed largest entry of V^T M V - I."""


class OrthonormalBasis(NamedTuple):
    """M-orthonormal columns, and the numbers of the given columns kept and dropped."""

    vectors: FloatArray
    kept: NDArray[np.intp]
    dropped: NDArray[np.intp]


def mass_orthonormalize(
    vectors: ArrayLike,
    mass: Matrix,
    *,
    rank_tolerance: float = 1e-8,
    reference_norms: ArrayLike | None = None,
) -> OrthonormalBasis:
    """Orthonormalise columns in the mass inner product, dropping those that depend on earlier ones.

    Gram-Schmidt, each column projected twice; column j is dropped if its remainder is shorter than
    rank_tolerance times its reference norm. Afterwards V^T M V = I to 1e-10.

    Parameters
    ----------
    vectors         : array (n, k)          any column scales; earlier columns have precedence
    mass            : sparse array (n, n)   symmetric positive definite
    reference_norms : array (k,)            M-norms with which remainders are compared, such as those before a
                                            projection of the columns; by default the M-norms of `vectors`
    Returns
    -------
    OrthonormalBasis   .vectors (n, r), .kept (r,), .dropped (k - r,) column numbers, ascending
    Raises
    ------
    ModelError      wrong shapes; entries not finite; a column of negative squared length (mass not definite)
    AccuracyError   the result is not orthonormal to 1e-10
    """
    columns = np.array(vectors, dtype=np.float64, order="F")
    if columns.ndim != 2 or columns.shape[0] != mass.shape[0]:
        raise ModelError(f"vectors have shape {columns.shape}; the mass matrix has {mass.shape[0]} rows")
    if not np.all(np.isfinite(columns)):
        raise ModelError("the vectors to orthonormalise contain NaN or infinite entries")
    norms = _mass_norms(columns, mass)
    reference = norms if reference_norms is None else np.asarray(reference_norms, dtype=np.float64)
    if reference.shape != norms.shape:
        raise ModelError(f"{norms.size} columns but reference norms of shape {reference.shape}")

    n, count = columns.shape
    basis = np.empty((n, count), order="F")
    mass_basis = np.empty((n, count), order="F")
    kept: list[int] = []
    for j in range(count):
        if norms[j] <= rank_tolerance * reference[j]:
            continue
        rank = len(kept)
        column = columns[:, j] / norms[j]
        column -= basis[:, :rank] @ (mass_basis[:, :rank].T @ column)
        mass_column = mass @ column
        remaining = float(np.sqrt(max(column @ mass_column, 0.0)))
        if remaining * norms[j] <= rank_tolerance * reference[j]:
            continue
        # Project again: the scaling of a short remainder also enlarges its components along earlier columns.
        column /= remaining
        column -= basis[:, :rank] @ (mass_basis[:, :rank].T @ column)
        mass_column = mass @ column
        length = np.sqrt(column @ mass_column)
        basis[:, rank], mass_basis[:, rank] = column / length, mass_column / length
        kept.append(j)

    result = np.ascontiguousarray(basis[:, : len(kept)])
    error = float(np.max(np.abs(result.T @ (mass @ result) - np.eye(len(kept))), initial=0.0))
    if not error < LARGEST_GRAM_ERROR:
        raise AccuracyError(f"the basis is M-orthonormal to {error:.1e} only; check the mass matrix")
    chosen = np.array(kept, dtype=np.intp)
    return OrthonormalBasis(result, chosen, np.setdiff1d(np.arange(count), chosen))


def _mass_norms(columns: FloatArray, mass: Matrix) -> FloatArray:
    squares = np.sum(columns * (mass @ columns), axis=0)
    if np.any(squares < 0):
        worst = int(np.argmin(squares))
        raise ModelError(
            f"column {worst} has the squared length {squares[worst]:.3e}: the mass is not definite; check it"
        )
    return np.sqrt(squares)
