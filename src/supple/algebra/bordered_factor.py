"""A factored sparse matrix with a narrow border, on the null space of linear constraints.

    [ K + W diag(c) W^T   A^T ] [ x ]   [ b ]
    [ A                    0  ] [ l ] = [ g ]

Most rows of K, the interior, are sparse and have a factor of their own. The other rows, the constraints `A`
and the columns `W` are few, and form the Schur complement.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy import sparse

from supple.algebra.sparse_factor import Matrix, SparseFactor, factorize_general, factorize_symmetric
from supple.arrays import FloatArray
from supple.errors import AccuracyError

LARGEST_REFINEMENT = 1e-3
"""Largest relative change of a solution by one refinement; above it the system counts as singular."""

_ROUNDING = 1e-13
"""Largest entry of `A - A^T`, relative to the largest of A, for which the interior A counts as symmetric."""


@dataclass(frozen=True, eq=False)
class BorderedFactor:
    """The factored system; built by `bordered_factor`."""

    matrix: sparse.csr_array
    """Matrix of the whole system, sparse (n + m + w, ..)"""
    n: int
    interior: NDArray[np.intp]
    border: NDArray[np.intp]
    factor: SparseFactor
    responses: FloatArray
    """Negative responses of the interior to unit values of the border, (n_interior, n_border)"""
    rows: sparse.csr_array
    """Coupling of the border to the interior, sparse"""
    remainder: tuple[FloatArray, NDArray[np.intp]]
    """L U factor of the scaled Schur complement"""
    scales: tuple[FloatArray, FloatArray]
    """Scales of the rows and columns of the Schur complement"""
    symmetric: bool
    """Whether the interior is symmetric"""

    def solve(self, loads: FloatArray, gaps: FloatArray | None = None) -> FloatArray:
        """`x` (n, k) for loads `b` (n, k) and constraint values `g` (m, k), by default zero; refined once."""
        return self._refined(loads, gaps)[: self.n]

    def solve_with_multipliers(self, loads: FloatArray, gaps: FloatArray) -> tuple[FloatArray, FloatArray]:
        """`x` (n, k) and `l` (m, k) for loads `b` (n, k) and constraint values `g` (m, k), refined once."""
        solution = self._refined(loads, gaps)
        return solution[: self.n], solution[self.n : self.n + len(gaps)]

    @cached_property
    def negative(self) -> int:
        """Number of negative eigenvalues of the whole symmetric system.

        Without columns W, it is m plus the number of K on `A x = 0`. Zero is returned if the interior is not
        symmetric, where the number is undefined. Source: Haynsworth.
        """
        if not self.symmetric:
            return 0
        outside: Any = self.matrix[self.border][:, self.border].toarray() - self.rows @ self.responses
        return self.factor.inertia.negative + int(np.sum(np.linalg.eigvalsh((outside + outside.T) / 2) < 0))

    def _refined(self, loads: FloatArray, gaps: FloatArray | None) -> FloatArray:
        right = np.zeros((self.matrix.shape[0], loads.shape[1]))
        right[: self.n] = loads
        if gaps is not None:
            right[self.n : self.n + len(gaps)] = gaps
        solution = self._once(right)
        return solution + self._once(right - self.matrix @ solution)

    def _once(self, right: FloatArray) -> FloatArray:
        inner = self.factor.solve(right[self.interior])
        rows, columns = self.scales
        left = rows[:, None] * (right[self.border] - self.rows @ inner)
        outer = columns[:, None] * scipy.linalg.lu_solve(self.remainder, left, check_finite=False)
        solution = np.empty_like(right)
        solution[self.interior] = inner - self.responses @ outer
        solution[self.border] = outer
        return solution

    def check(self) -> None:
        """Raise AccuracyError if the system is singular to working precision."""
        right = np.zeros((self.matrix.shape[0], 1))
        diagonal = abs(self.matrix.diagonal()[: self.n])
        right[: self.n, 0] = np.sqrt(diagonal) * np.random.default_rng(0).standard_normal(self.n)
        solution = self._once(right)
        change = self._once(right - self.matrix @ solution)
        moved, size = (np.linalg.norm(np.sqrt(diagonal) * part[: self.n, 0]) for part in (change, solution))
        if not moved < LARGEST_REFINEMENT * size:  # NaN fails too
            share = moved / size if size else np.nan
            raise _singular(self.n, f"iterative refinement changes a solution by {share:.1e} of its size")


def bordered_factor(
    matrix: Matrix,
    constraint: Matrix,
    interior: NDArray[np.intp],
    columns: FloatArray | None = None,
    weights: FloatArray | None = None,
) -> BorderedFactor:
    """Factor a sparse matrix on the null space of a constraint.

    Parameters
    ----------
    matrix : sparse (n, n)      K, of symmetric pattern; its `interior` rows and columns regular
    constraint : sparse (m, n)  A, of full row rank
    interior : (k,)             numbers of the rows to be eliminated sparsely
    columns : (n, w)            W; by default none
    weights : (w,)              c, none of them zero

    Raises AccuracyError if the system is singular to working precision.
    """
    n = int(matrix.shape[0])
    parts: list[list[Any]] = [[sparse.csr_array(matrix), constraint.T], [constraint, None]]
    if columns is not None and weights is not None and columns.size:
        # W diag(c) W^T x with further unknowns, z = diag(c) W^T x.
        wide = sparse.csr_array(columns)
        parts = [
            [*parts[0], wide],
            [*parts[1], None],
            [wide.T, None, -sparse.diags_array(1 / weights)],
        ]
    whole: Any = sparse.csr_array(sparse.block_array(parts, format="csr"))
    border = np.setdiff1d(np.arange(whole.shape[0]), interior)
    upper: Any = whole[interior]
    inner: Any = sparse.csc_array(upper[:, interior])
    skew = abs(inner - inner.T).max()
    # A symmetric factor is half the work; refinement corrects the asymmetry due to rounding.
    symmetric = skew <= _ROUNDING * abs(inner).max()
    factor = factorize_symmetric(inner) if symmetric else factorize_general(inner)
    coupling: Any = sparse.csc_array(upper[:, border])
    rows: Any = sparse.csr_array(whole[border][:, interior])
    touched = np.flatnonzero(np.diff(coupling.indptr))
    responses = np.zeros(coupling.shape)
    responses[:, touched] = factor.solve(coupling[:, touched].toarray())
    left = whole[border][:, border].toarray() - rows @ responses
    scales = _balanced(left)
    with warnings.catch_warnings():
        # A pivot of exactly zero depends on rounding: it is reported like every other singular system.
        warnings.simplefilter("ignore", scipy.linalg.LinAlgWarning)
        remainder = scipy.linalg.lu_factor(scales[0][:, None] * left * scales[1], check_finite=False)
    if not remainder[0].diagonal().all():
        raise _singular(n, "the Schur complement of constraints and columns has a pivot of zero")
    solved = factor, responses, rows, remainder, scales
    bordered = BorderedFactor(whole, n, interior, border, *solved, symmetric=bool(symmetric))
    bordered.check()
    return bordered


def _singular(n: int, seen: str) -> AccuracyError:
    return AccuracyError(f"the bordered matrix of {n} freedoms is singular to working precision: {seen}")


def _balanced(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Scales that give every row and column a largest entry near one."""
    rows, columns, sizes = np.ones(len(matrix)), np.ones(len(matrix)), abs(matrix)
    for _ in range(4):
        scaled = rows[:, None] * sizes * columns
        by_row, by_column = (scaled.max(axis=axis, initial=0.0) for axis in (1, 0))
        rows = rows / np.sqrt(np.where(by_row > 0, by_row, 1.0))
        columns = columns / np.sqrt(np.where(by_column > 0, by_column, 1.0))
    return rows, columns
