"""Cuboids along x: a solid block of tetrahedra or hexahedra, and a thin-walled box beam of triangles."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray
from supple.mesh.cell_type import CellType
from supple.mesh.extrusion import extrude
from supple.mesh.mesh import Mesh
from supple.mesh.structured_grid import (
    alternating_triangles,
    check_counts,
    check_sizes,
    grid_perimeter,
    grid_quads,
)

__all__ = ["block", "box_beam"]


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
    x, y, z = _divided(length, width, height, n_length, n_width, n_height)
    grid = np.arange(y.size * z.size).reshape(y.size, z.size)
    section = np.column_stack([np.repeat(y, z.size), np.tile(z, y.size)])
    sides = {"y_min": grid[0], "y_max": grid[-1], "z_min": grid[:, 0], "z_max": grid[:, -1]}
    return extrude(section, grid_quads(grid), x, cell_type, section_sets=sides)


def box_beam(length: float, width: float, height: float, n_length: int, n_width: int, n_height: int) -> Mesh:
    """Mid-surface of a rectangular tube along x, open at both ends; normals point outward.

    The walls lie at y = +-width/2 and z = +-height/2, 0 <= x <= length.

    Parameters
    ----------
    length, width, height : float         m; width and height between mid-surfaces
    n_length, n_width, n_height : int     cells along x, y, z, two triangles each
    Returns
    -------
    Mesh   node sets root (x = 0), tip (x = length); cell sets z_min, y_max, z_max, y_min (the walls)
    Raises
    ------
    MeshError   sizes not positive; counts below one
    """
    x, y, z = _divided(length, width, height, n_length, n_width, n_height)
    rim = grid_perimeter(np.arange(y.size * z.size).reshape(y.size, z.size))
    around = rim.size
    section = np.column_stack([y[rim // z.size], z[rim % z.size]])
    nodes = np.column_stack([np.repeat(x, around), np.tile(section, (x.size, 1))])

    grid = np.arange(x.size * around).reshape(x.size, around)
    closed = np.column_stack([grid, grid[:, 0]])
    # The rim runs from y towards z, so its direction crossed with x points outward.
    triangles = alternating_triangles(closed.T)
    walls = np.repeat(np.arange(4), np.array([n_width, n_height, n_width, n_height]) * 2 * n_length)
    cell_sets = {
        name: {CellType.TRIANGLE3: np.flatnonzero(walls == number)}
        for number, name in enumerate(["z_min", "y_max", "z_max", "y_min"])
    }
    return Mesh(nodes, {CellType.TRIANGLE3: triangles}, {"root": grid[0], "tip": grid[-1]}, cell_sets)


def _divided(
    length: float, width: float, height: float, n_length: int, n_width: int, n_height: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coordinates x, y, z of the nodes; MeshError for sizes or counts that are not positive."""
    check_sizes(length=length, width=width, height=height)
    check_counts(n_length=n_length, n_width=n_width, n_height=n_height)
    x = np.linspace(0.0, length, n_length + 1)
    y = np.linspace(-width / 2, width / 2, n_width + 1)
    z = np.linspace(-height / 2, height / 2, n_height + 1)
    return x, y, z
