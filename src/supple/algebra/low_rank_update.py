"""Linear systems whose matrix is a factored one plus a symmetric product of few columns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from supple.algebra.sparse_factor import SparseFactor
from supple.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class LowRankUpdate:
    """A + W diag(c) W^T, with A factored and W (n, m), m small; the sum is never formed.

        x = y - Z (diag(1 / c) + W^T Z)^-1 W^T y,     A y = b,  A Z = W

    factor : SparseFactor       of A, regular
    columns : (n, m)            W
    weights : (m,)              c, none of them zero
    Source: M. A. Woodbury, Inverting Modified Matrices, Princeton (1950).
    """

    factor: SparseFactor
    columns: FloatArray
    weights: FloatArray

    def solve(self, loads: ArrayLike) -> FloatArray:
        """Solve for loads (n,) or (n, k); the solution has the same shape."""
        y = self.factor.solve(loads)
        return y - self._responses @ np.linalg.solve(self._capacitance, self.columns.T @ y)

    @cached_property
    def _responses(self) -> FloatArray:
        return self.factor.solve(self.columns)

    @cached_property
    def _capacitance(self) -> FloatArray:
        return np.diag(1 / self.weights) + self.columns.T @ self._responses
