"""Cylinder shell: a sector of a thin circular tube, or the whole tube, of triangles."""

from __future__ import annotations

import math

import numpy as np

from supple.errors import MeshError
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh
from supple.mesh.structured_grid import alternating_triangles, check_counts, check_sizes

__all__ = ["cylinder_shell"]


def cylinder_shell(
    radius: float,
    length: float,
    n_length: int,
    n_around: int,
    *,
    start_angle: float = 0.0,
    end_angle: float = 2 * math.pi,
) -> Mesh:
    """Circular mid-surface about the x axis, from start to end angle; normals point outward.

        x, y, z = x, radius sin(angle), radius cos(angle)     0 <= x <= length

    Parameters
    ----------
    radius, length : float            m
    n_length, n_around : int          cells along and around the axis, two triangles each
    start_angle, end_angle : float    rad, from the z axis towards y; a full turn closes the tube
    Returns
    -------
    Mesh   node sets x_min, x_max and, on a sector, start, end (its straight edges, along x)
    Raises
    ------
    MeshError   sizes not positive; counts below one (around a tube, three); end not in (start, start + 2 pi]
    """
    check_sizes(radius=radius, length=length)
    turn = end_angle - start_angle
    if not 0 < turn <= 2 * math.pi * (1 + 1e-12):
        raise MeshError(
            f"the sector runs from {start_angle} to {end_angle} rad; its end lies above its start, "
            "by at most a full turn"
        )
    closed = math.isclose(turn, 2 * math.pi)
    check_counts(n_length=n_length)
    check_counts(3 if closed else 1, n_around=n_around)

    angle = np.linspace(start_angle, end_angle, n_around + 1)[: n_around if closed else None]
    x = np.linspace(0.0, length, n_length + 1)
    grid = np.arange(x.size * angle.size).reshape(x.size, angle.size)
    nodes = np.column_stack(
        [
            np.repeat(x, angle.size),
            np.tile(radius * np.sin(angle), x.size),
            np.tile(radius * np.cos(angle), x.size),
        ]
    )
    node_sets = {"x_min": grid[0], "x_max": grid[-1]}
    if closed:
        grid = np.column_stack([grid, grid[:, 0]])
    else:
        node_sets |= {"start": grid[:, 0], "end": grid[:, -1]}
    return Mesh(nodes, {CellType.TRIANGLE3: alternating_triangles(grid)}, node_sets)
