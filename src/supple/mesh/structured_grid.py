"""Parametric shapes: checks of sizes and cell counts, and cells between the nodes of a two-way table."""

from __future__ import annotations

import math

import numpy as np

from supple.arguments import check_number
from supple.arrays import IntArray
from supple.errors import MeshError

MOST_CELLS = 20_000_000
"""Largest cell count of a parametric shape: beyond it the nodes alone fill the memory of a workstation."""


def check_sizes(**sizes: float) -> None:
    """Raise MeshError unless every named size is finite and positive."""
    for name, size in sizes.items():
        check_number(name, size)
        if not (math.isfinite(size) and size > 0):
            raise MeshError(f"{name} = {size}; give a finite size above zero")


def check_counts(least: int = 1, **counts: int) -> None:
    """Raise MeshError unless counts are whole, at least `least`, and their product at most MOST_CELLS."""
    for name, count in counts.items():
        check_number(name, count)
        if not math.isfinite(count) or count != int(count) or count < least:
            raise MeshError(f"{name} = {count}; give a whole number of cells, at least {least}")
    cells = math.prod(map(int, counts.values()))
    if cells > MOST_CELLS:
        raise MeshError(
            f"{' x '.join(f'{name} = {count}' for name, count in counts.items())} make {cells:.3g} cells; "
            f"at most {MOST_CELLS} are made: choose fewer"
        )


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
