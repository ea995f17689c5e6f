"""Linear systems whose matrix is a factored one plus a symmetric product of few columns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.algebra.sparse_factor import SparseFactor


@dataclass(frozen=True, eq=False)
class LowRankUpdate:
    """A + c W W^T, with A factored and W (n, m), m small: never formed.

        x = y - Z (I / c + W^T Z)^-1 W^T y,     A y = b,  A Z = W

    factor : SparseFactor       of A, regular
    columns : (n, m)            W
    weight : float              c, positive
    Source: M. A. Woodbury, Inverting Modified Matrices, Princeton (1950).
    """

    factor: SparseFactor
    columns: NDArray[np.float64]
    weight: float

    def solve(self, loads: ArrayLike) -> NDArray[np.float64]:
        """Solve for loads (n,) or (n, k); the solution has the same shape."""
        y = self.factor.solve(loads)
        return y - self._answers @ np.linalg.solve(self._capacitance, self.columns.T @ y)

    @cached_property
    def _answers(self) -> NDArray[np.float64]:
        return self.factor.solve(self.columns)

    @cached_property
    def _capacitance(self) -> NDArray[np.float64]:
        return np.eye(self.columns.shape[1]) / self.weight + self.columns.T @ self._answers
