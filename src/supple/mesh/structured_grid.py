"""Structured grids: cells between the nodes of a two-way table of node numbers."""

from __future__ import annotations

import numpy as np

from supple.arrays import IntArray


def grid_quads(grid: IntArray) -> IntArray:
    """Quadrilaterals (n_u * n_v, 4) of a table (n_u + 1, n_v + 1) of node numbers, oriented from u to v.

    A closed surface repeats its first row or column of node numbers at the end.
    """
    corners = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
    return np.stack(corners, axis=-1).reshape(-1, 4)


def alternating_triangles(grid: IntArray) -> IntArray:
    """Triangles (2 n_u n_v, 3) of a table of node numbers, oriented from u to v.

    The diagonals alternate as in the Union Jack, so that even numbers of cells give a symmetric mesh with no
    preferred direction of shear.
    """
    a, b, c, d = grid_quads(grid).T
    n_u, n_v = grid.shape[0] - 1, grid.shape[1] - 1
    even = ((np.arange(n_u)[:, None] + np.arange(n_v)) % 2 == 0).ravel()
    rising = np.stack([a, b, c, a, c, d], axis=1)
    falling = np.stack([a, b, d, b, c, d], axis=1)
    return np.where(even[:, None], rising, falling).reshape(-1, 3)


def grid_perimeter(grid: IntArray) -> IntArray:
    """Node numbers (2 (n_u + n_v),) around a table of node numbers, from its first, oriented from u to v."""
    return np.concatenate([grid[:-1, 0], grid[-1, :-1], grid[:0:-1, -1], grid[0, :0:-1]])
