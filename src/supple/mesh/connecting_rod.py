"""Connecting rod: two eyes with bores, joined by a tapered shank, of tetrahedra or hexahedra."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import MeshError
from supple.mesh.cell_type import CellType
from supple.mesh.extrusion import extrude
from supple.mesh.mesh import Mesh
from supple.mesh.structured_grid import check_counts, check_sizes, grid_quads

__all__ = ["Eye", "RodCells", "RodOutline", "connecting_rod"]


@dataclass(frozen=True)
class Eye:
    """One end of a connecting rod: a ring about a bore, and the width of the shank at it.

    bore : m, radius of the bore
    rim : m, outer radius of the ring
    shank_width : m, width of the shank at the ring, less than twice the rim's radius
    """

    bore: float
    rim: float
    shank_width: float

    def __post_init__(self) -> None:
        check_sizes(bore=self.bore, rim=self.rim, shank_width=self.shank_width)
        if self.bore >= self.rim:
            raise MeshError(f"an eye's bore, radius {self.bore}, leaves no ring within the rim's {self.rim}")
        if self.shank_width >= 2 * self.rim:
            raise MeshError(
                f"a shank {self.shank_width} wide does not meet an eye of diameter {2 * self.rim}: narrow it"
            )

    @property
    def shank_angle(self) -> float:
        """Half the angle, rad, over which the shank meets the rim."""
        return float(np.arcsin(self.shank_width / (2 * self.rim)))

    @property
    def chord(self) -> float:
        """Distance from the bore's centre to the chord on which the shank's corners lie, m."""
        return self.rim * float(np.cos(self.shank_angle))

    @property
    def area(self) -> float:
        """Area of the ring, m^2."""
        return np.pi * (self.rim**2 - self.bore**2)

    @property
    def segment(self) -> float:
        """Area of the disc beyond the chord, m^2, contained in both the ring and the shank's trapezoid."""
        angle = self.shank_angle
        return self.rim**2 * (angle - float(np.sin(angle) * np.cos(angle)))


@dataclass(frozen=True)
class RodOutline:
    """Shape of a connecting rod: big eye about the origin, small eye at x = length, bores along z.

    length : m, between the bores' axes
    thickness : m, along z, about z = 0
    """

    length: float
    thickness: float
    big: Eye
    small: Eye

    def __post_init__(self) -> None:
        check_sizes(length=self.length, thickness=self.thickness)
        if self.big.rim + self.small.rim >= self.length:
            raise MeshError(
                f"eyes of radii {self.big.rim} and {self.small.rim} overlap at a distance of {self.length}"
            )

    @property
    def volume(self) -> float:
        """Exact volume: both rings, and the trapezoid between the chords less the discs' segments, m^3."""
        span = self.length - self.big.chord - self.small.chord
        shank = 0.5 * (self.big.shank_width + self.small.shank_width) * span
        rings = self.big.area + self.small.area
        return self.thickness * (rings + shank - self.big.segment - self.small.segment)


@dataclass(frozen=True)
class RodCells:
    """Numbers of hexahedra; six tetrahedra to a hexahedron.

    around : around each rim, besides those that meet the shank     ring : from bore to rim
    shank : along the shank                                         width : across it
    thickness : along z
    """

    around: int = 27
    ring: int = 2
    shank: int = 23
    width: int = 5
    thickness: int = 3

    def __post_init__(self) -> None:
        check_counts(ring=self.ring, shank=self.shank, width=self.width, thickness=self.thickness)
        check_counts(least=3, around=self.around)


def connecting_rod(outline: RodOutline, cells: RodCells, cell_type: CellType) -> Mesh:
    """Connecting rod in the x-y plane with its bores along z: rings of quads, blended into the shank.

    Parameters
    ----------
    cells : RodCells           numbers of cells; the default gives 4374 tetrahedra
    cell_type : CellType       TETRA4, TETRA10, HEXA8 or HEXA20; mid-edge nodes lie on the true surface
    Returns
    -------
    Mesh   node sets big_bore, small_bore, big_rim, small_rim (without the shank), z_min, z_max
    Raises
    ------
    MeshError   another cell type; `Eye`, `RodOutline` and `RodCells` check sizes and counts
    """
    section, quads, sets = _section(outline, cells)
    half = 0.5 * outline.thickness
    stations = np.linspace(-half, half, cells.thickness + 1)
    # The extrusion is along x over a y-z section; a cyclic change of the axes makes it z over x-y.
    mesh = extrude(section, quads, stations, cell_type, section_sets=sets)
    nodes = mesh.nodes[:, [1, 2, 0]].copy()
    circles = {
        "big_bore": (0.0, outline.big.bore),
        "big_rim": (0.0, outline.big.rim),
        "small_bore": (outline.length, outline.small.bore),
        "small_rim": (outline.length, outline.small.rim),
    }
    for name, (centre, radius) in circles.items():
        _move_to_circle(nodes, mesh.nodes_of(name), centre, radius)
    node_sets = {"z_min": mesh.nodes_of("root"), "z_max": mesh.nodes_of("tip")}
    return replace(mesh, nodes=nodes, node_sets=node_sets | {name: mesh.nodes_of(name) for name in circles})


def _section(outline: RodOutline, cells: RodCells) -> tuple[FloatArray, IntArray, dict[str, IntArray]]:
    """Points (P, 2), quads (Q, 4) and the points of bores and rims."""
    big, big_grid = _ring(outline.big, cells, toward=1.0)
    small, small_grid = _ring(outline.small, cells, toward=-1.0)
    small[:, 0] += outline.length
    small_grid += len(big)
    meeting = slice(0, cells.width + 1)
    # Both rings begin at the shank. The small one has the opposite sense, so that both arcs run from y < 0 to
    # y > 0.
    start, end = big_grid[-1, meeting], small_grid[-1, meeting]
    points = np.vstack([big, small])
    blend = (np.arange(1, cells.shank) / cells.shank)[:, None, None]
    shank = (1 - blend) * points[start] + blend * points[end]
    inner = len(points) + np.arange(shank.shape[0] * shank.shape[1]).reshape(shank.shape[:2])
    shank_grid = np.vstack([start, inner, end])
    quads = np.vstack([grid_quads(big_grid), grid_quads(small_grid)[:, ::-1], grid_quads(shank_grid)])
    sets = {"big_bore": big_grid[0, :-1], "small_bore": small_grid[0, :-1]}
    sets |= {"big_rim": big_grid[-1, cells.width :], "small_rim": small_grid[-1, cells.width :]}
    return np.vstack([points, shank.reshape(-1, 2)]), quads, sets


def _ring(eye: Eye, cells: RodCells, *, toward: float) -> tuple[FloatArray, IntArray]:
    """Points of a ring about the origin, and their numbers (ring + 1, around + width + 1), bore first.

    The columns go once around; the last column repeats the first. The first width + 1 columns are at the
    shank, in the direction `toward` of x, and run from y < 0 to y > 0.
    """
    half = eye.shank_angle
    joined = np.linspace(-half, half, cells.width + 1)
    free = np.linspace(half, 2 * np.pi - half, cells.around + 1)[1:-1]
    angle = np.concatenate([joined, free])
    radius = np.linspace(eye.bore, eye.rim, cells.ring + 1)[:, None]
    points = np.stack([toward * radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    numbers = np.arange(radius.size * angle.size).reshape(radius.size, angle.size)
    return points.reshape(-1, 2), np.column_stack([numbers, numbers[:, 0]])


def _move_to_circle(nodes: FloatArray, members: IntArray, centre: float, radius: float) -> None:
    """Move nodes radially in the x-y plane to a distance `radius` from (centre, 0)."""
    arm = nodes[members, :2] - [centre, 0.0]
    nodes[members, :2] = [centre, 0.0] + radius * arm / np.linalg.norm(arm, axis=1, keepdims=True)
