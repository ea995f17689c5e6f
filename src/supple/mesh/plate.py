"""Plate: a flat rectangle of triangles."""

from __future__ import annotations

import numpy as np

from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh
from supple.mesh.shape_arguments import check_counts, check_sizes
from supple.mesh.structured_grid import alternating_triangles, grid_perimeter

__all__ = ["plate"]


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
    check_sizes(length=length, width=width)
    check_counts(n_length=n_length, n_width=n_width)
    x = np.linspace(0.0, length, n_length + 1)
    y = np.linspace(0.0, width, n_width + 1)
    grid = np.arange(x.size * y.size).reshape(x.size, y.size)
    nodes = np.column_stack([np.repeat(x, y.size), np.tile(y, x.size), np.zeros(grid.size)])
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
