"""Strip: a flat beam of triangles."""

from __future__ import annotations

import numpy as np

from supple.errors import MeshError
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh
from supple.mesh.shape_arguments import check_counts, check_sizes
from supple.mesh.structured_grid import alternating_triangles

__all__ = ["strip"]


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
    check_sizes(length=length, width=width)
    check_counts(n_length=n_length, n_width=n_width)
    if n_width % 2:
        raise MeshError(f"n_width = {n_width} is odd, so the strip has no node on its axis; choose it even")
    x = np.linspace(0.0, length, n_length + 1)
    y = np.linspace(-width / 2, width / 2, n_width + 1)
    grid = np.arange(x.size * y.size).reshape(x.size, y.size)
    nodes = np.column_stack([np.repeat(x, y.size), np.tile(y, x.size), np.zeros(grid.size)])
    axis = grid[:, n_width // 2]
    node_sets = {
        "root": grid[0],
        "tip": grid[-1],
        "axis": axis,
        "root_centre": axis[:1],
        "tip_centre": axis[-1:],
    }
    return Mesh(nodes, {CellType.TRIANGLE3: alternating_triangles(grid)}, node_sets)
