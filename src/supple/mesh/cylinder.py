"""Cylinders about x: a solid bar of tetrahedra or hexahedra, and a thin tube or a sector of triangles."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from supple.arrays import IntArray
from supple.errors import MeshError
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

__all__ = ["cylinder", "cylinder_shell"]

# Half the side of the square core divided by the radius, such that core and ring cells are of similar shape.
CORE = 0.45


def cylinder(
    radius: float, length: float, n_core: int, n_ring: int, n_length: int, cell_type: CellType
) -> Mesh:
    """Solid cylinder about the x axis, 0 <= x <= length: a square core in a round ring.

    Parameters
    ----------
    radius, length : float       m
    n_core : int                 hexahedra along a side of the core; 4 n_core lie around the cylinder
    n_ring : int                 layers of hexahedra around the core
    n_length : int               hexahedra along x; six tetrahedra to a hexahedron
    cell_type : CellType         TETRA4, TETRA10, HEXA8 or HEXA20; mid-edge nodes lie on the true surface
    Returns
    -------
    Mesh   node sets root (x = 0), tip (x = length), surface (at the radius)
    Raises
    ------
    MeshError   sizes not positive; counts below one; another cell type
    """
    check_sizes(radius=radius, length=length)
    check_counts(n_core=n_core, n_ring=n_ring, n_length=n_length)
    section, quads, rim = _disc(radius, n_core, n_ring)
    x = np.linspace(0.0, length, n_length + 1)
    mesh = extrude(section, quads, x, cell_type, section_sets={"surface": rim})
    nodes = mesh.nodes.copy()
    surface = mesh.nodes_of("surface")
    nodes[surface, 1:] *= radius / np.linalg.norm(nodes[surface, 1:], axis=1, keepdims=True)
    return replace(mesh, nodes=nodes)


def _disc(radius: float, n_core: int, n_ring: int):
    """Points (P, 2), quads (Q, 4) and rim points (4 n_core,) of a disc."""
    side = np.linspace(-CORE, CORE, n_core + 1)
    core = np.column_stack([np.repeat(side, n_core + 1), np.tile(side, n_core + 1)])
    core_grid = np.arange(len(core)).reshape(n_core + 1, n_core + 1)
    core_rim = grid_perimeter(core_grid)
    around = np.arange(4 * n_core)
    angle = -0.75 * np.pi + 0.5 * np.pi * around / n_core  # from the core's first corner
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    outward = (np.arange(1, n_ring + 1) / n_ring)[:, None, None]
    ring = (1 - outward) * core[core_rim] + outward * circle
    section = radius * np.vstack([core, ring.reshape(-1, 2)])

    layers = np.vstack([core_rim, len(core) + np.arange(4 * n_core * n_ring).reshape(n_ring, -1)])
    closed: IntArray = np.column_stack([layers, layers[:, 0]])
    quads = np.vstack([grid_quads(core_grid), grid_quads(closed)])
    return section, quads, layers[-1]


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
