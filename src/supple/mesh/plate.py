"""Plate and strip: flat rectangles of triangles."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import MeshError
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh
from supple.mesh.structured_grid import alternating_triangles, check_counts, check_sizes, grid_perimeter

__all__ = ["plate", "strip"]


def plate(length: float, width: float, n_length: int, n_width: int) -> Mesh:
    """Rectangle of triangles over 0 <= x <= length, 0 <= y <= width, z = 0; normals along z.

    Parameters
    ----------
    length, width : float         m
    n_length, n_width : int       cells along x and y, two triangles each; symmetric when both are even
    Returns
    -------
    Mesh   node sets x_min, x_max, y_min, y_max, boundary (all around) and, when both counts are even, centre
    Raises
    ------
    MeshError   sizes not positive; counts below one
    """
    nodes, grid = _rectangle(length, width, n_length, n_width, low=0.0)
    node_sets = {
        "x_min": grid[0],
        "x_max": grid[-1],
        "y_min": grid[:, 0],
        "y_max": grid[:, -1],
        "boundary": grid_perimeter(grid),
    }
    if n_length % 2 == 0 and n_width % 2 == 0:
        node_sets["centre"] = grid[n_length // 2, n_width // 2, None]
    return Mesh(nodes, {CellType.TRIANGLE3: alternating_triangles(grid)}, node_sets)


def strip(length: float, width: float, n_length: int, n_width: int) -> Mesh:
    """Strip of triangles over 0 <= x <= length, -width/2 <= y <= width/2, z = 0; normals along z.

    Parameters
    ----------
    length, width : float         m
    n_length, n_width : int       cells along x and y, two triangles each; n_width even, so that the strip is
                                  symmetric and has nodes on its axis
    Returns
    -------
    Mesh   node sets root (x = 0), tip (x = length), axis (y = 0, root to tip), root_centre, tip_centre
    Raises
    ------
    MeshError   sizes not positive; counts below one; n_width odd
    """
    nodes, grid = _rectangle(length, width, n_length, n_width, low=-0.5)
    if n_width % 2:
        raise MeshError(f"n_width = {n_width} is odd, so the strip has no node on its axis; choose it even")
    axis = grid[:, n_width // 2]
    node_sets = {
        "root": grid[0],
        "tip": grid[-1],
        "axis": axis,
        "root_centre": axis[:1],
        "tip_centre": axis[-1:],
    }
    return Mesh(nodes, {CellType.TRIANGLE3: alternating_triangles(grid)}, node_sets)


def _rectangle(
    length: float, width: float, n_length: int, n_width: int, *, low: float
) -> tuple[FloatArray, IntArray]:
    """Nodes (N, 3) and their numbers (n_length + 1, n_width + 1); y begins at `low` times the width."""
    check_sizes(length=length, width=width)
    check_counts(n_length=n_length, n_width=n_width)
    x = np.linspace(0.0, length, n_length + 1)
    y = np.linspace(low * width, (low + 1) * width, n_width + 1)
    grid = np.arange(x.size * y.size).reshape(x.size, y.size)
    return np.column_stack([np.repeat(x, y.size), np.tile(y, x.size), np.zeros(grid.size)]), grid
