"""Block: a solid cuboid of tetrahedra or hexahedra."""

from __future__ import annotations

import numpy as np

from supple.mesh.cell_type import CellType
from supple.mesh.extrusion import extrude
from supple.mesh.mesh import Mesh
from supple.mesh.structured_grid import check_counts, check_sizes, grid_quads

__all__ = ["block"]


def block(
    length: float,
    width: float,
    height: float,
    n_length: int,
    n_width: int,
    n_height: int,
    cell_type: CellType,
) -> Mesh:
    """Cuboid over 0 <= x <= length, -width/2 <= y <= width/2, -height/2 <= z <= height/2.

    Parameters
    ----------
    length, width, height : float         m
    n_length, n_width, n_height : int     number of hexahedra along x, y, z
    cell_type : CellType                  HEXA8, HEXA20, TETRA4 or TETRA10; for tetrahedra, each hexahedron is
                                          divided into six
    Returns
    -------
    Mesh   node sets root (x = 0), tip (x = length), y_min, y_max, z_min, z_max
    Raises
    ------
    MeshError   a size that is not positive; a number of hexahedra below one; another cell type
    """
    check_sizes(length=length, width=width, height=height)
    check_counts(n_length=n_length, n_width=n_width, n_height=n_height)
    x = np.linspace(0.0, length, n_length + 1)
    y = np.linspace(-width / 2, width / 2, n_width + 1)
    z = np.linspace(-height / 2, height / 2, n_height + 1)
    grid = np.arange(y.size * z.size).reshape(y.size, z.size)
    section = np.column_stack([np.repeat(y, z.size), np.tile(z, y.size)])
    sides = {"y_min": grid[0], "y_max": grid[-1], "z_min": grid[:, 0], "z_max": grid[:, -1]}
    return extrude(section, grid_quads(grid), x, cell_type, section_sets=sides)
