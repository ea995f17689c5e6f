"""Positions along a blade, so close that straight pieces represent its curve; matrices at these positions."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray

PIECES = 100
"""Smallest number of straight pieces of a blade: no step exceeds 1 / PIECES of its length."""


def fine_grid(grid: FloatArray) -> FloatArray:
    """The ascending grid (n,) with points added so that no step exceeds 1 / PIECES of its whole length."""
    parts = np.ceil(np.diff(grid) / (grid[-1] - grid[0]) * PIECES - 1e-9).astype(int)
    steps = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(grid[:-1], grid[1:], parts, strict=True)]
    return np.append(np.concatenate(steps), grid[-1])


def matrices_at(fine: FloatArray, grid: FloatArray, matrices: FloatArray) -> FloatArray:
    """Matrices (k, 6, 6) at `fine` (k,), linear between the matrices (n, 6, 6) at the grid (n,)."""
    flat = matrices.reshape(len(grid), 36)
    return np.column_stack([np.interp(fine, grid, column) for column in flat.T]).reshape(-1, 6, 6)
