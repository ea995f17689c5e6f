"""Beams and rods as prisms of their sections."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray, IntArray
from supple.fem import BeamSection, CoupledBeamSection, FiniteElementModel, LineSection, RodSection, Section
from supple.fem.beam_stress import rod_line
from supple.fem.model import line_of
from supple.mesh.section_geometry import ROUND_CORNERS

_Loop = FloatArray
"""(k, 2) corners of a convex polygon"""


class BeamSkin(NamedTuple):
    """Triangles over points attached to nodes.

    triangles, mesh_lines : (T, 3) as in a `Skin`; triangles have the numbers of the P points
    nodes : (P,) node of each point;  arms : (P, 3) from the node to the point, undeformed, m
    groups : (P,) group of the stress of each point, as in `SurfacePoints`
    """

    triangles: IntArray
    mesh_lines: NDArray[np.bool_]
    nodes: IntArray
    arms: FloatArray
    groups: IntArray


MOST_OUTLINED = 1000
"""Largest number of beams drawn with their outlines; above it, bounding boxes are drawn."""


def beam_skin(model: FiniteElementModel, section: Section, ranks: IntArray | None) -> BeamSkin:
    """The prisms of the beams of one section, open where the section is hollow.

    ranks : (E, 2) number of each end among the beam ends at its node (`beam_end_ranks`); None without stress
    """
    given = section.property
    assert isinstance(given, LineSection | RodSection)
    corners = section.corners(model.mesh)
    line = rod_line(corners) if isinstance(given, RodSection) else line_of(model.mesh, section)
    fine = len(model.mesh.cells[section.cell_type]) <= MOST_OUTLINED
    first, second = (outlines(given, end) if fine else _box(*outlines(given, end)) for end in (0, 1))
    loops, hole = first
    if [len(own) for own in (*second[0], second[1])] != [len(own) for own in (*loops, hole)]:
        second = first  # tapered to another shape
    rims = [np.concatenate([*own_loops, own_hole]) for own_loops, own_hole in (first, second)]
    local = np.stack(
        [line.arms[:, [end]] + np.pad(rim, ((0, 0), (1, 0)))[None] for end, rim in enumerate(rims)], axis=1
    )
    arms = local @ line.axes[:, None]
    n_cells, _, n_corners, _ = arms.shape
    triangles, lines = _prism(tuple(len(loop) for loop in loops), len(hole))
    first = 2 * n_corners * np.arange(n_cells)
    return BeamSkin(
        (first[:, None, None] + triangles).reshape(-1, 3),
        np.tile(lines, (n_cells, 1)),
        np.repeat(section.nodes(model.mesh).ravel(), n_corners),
        arms.reshape(-1, 3),
        np.full(arms.size // 3, -1)
        if ranks is None
        else np.repeat(np.where(ranks < 0, -1, 1 + ranks).ravel(), n_corners),
    )


def outlines(given: LineSection | RodSection, end: int) -> tuple[tuple[_Loop, ...], _Loop]:
    """Convex polygons of a section at one end, and its hole (0, 2) or (k, 2).

    A section of unknown shape becomes an ellipse. If the area of the section were on the rim of this ellipse,
    the radii of gyration would be those of the section. A rod is round.
    """
    none = np.empty((0, 2))
    if isinstance(given, RodSection):
        return (np.sqrt(given.area / np.pi) * _circle(),), none
    own = given if end == 0 or given.second is None else given.second
    if isinstance(own, BeamSection):
        if own.geometry is not None and own.geometry.loops:
            geometry = own.geometry
            return tuple(np.array(loop) for loop in geometry.loops), np.array(geometry.hole).reshape(-1, 2)
        centre, area = np.array(own.neutral), own.area
        second = np.array([[own.I1, own.I12], [own.I12, own.I2]])
    else:
        assert isinstance(own, CoupledBeamSection)
        area, mass = own.mass[0, 0], own.mass
        centre = np.array([-mass[0, 5], mass[0, 4]]) / (area or 1.0)
        moments = np.array([[mass[5, 5], -mass[4, 5]], [-mass[4, 5], mass[4, 4]]])
        second = moments - area * np.outer(centre, centre)
    values, vectors = np.linalg.eigh(2 * second / (area or 1.0))
    radii = np.sqrt(np.maximum(values, 0.0))
    if not isinstance(own, CoupledBeamSection):
        radii = np.where(radii > 0, radii, np.sqrt(area / np.pi))
    return (centre + _circle() @ (vectors * radii) @ vectors.T,), none


def _box(loops: tuple[_Loop, ...], hole: _Loop) -> tuple[tuple[_Loop, ...], _Loop]:
    """The bounding rectangle of a section, in place of its outline."""
    low, high = (pick(np.concatenate(loops), axis=0) for pick in (np.min, np.max))
    return (np.array([high, (low[0], high[1]), low, (high[0], low[1])]),), hole[:0]


def _circle() -> FloatArray:
    angles = 2 * np.pi * np.arange(ROUND_CORNERS) / ROUND_CORNERS
    return np.column_stack([np.cos(angles), np.sin(angles)])


def _prism(loops: tuple[int, ...], hole: int) -> tuple[IntArray, NDArray[np.bool_]]:
    """Triangles (T, 3) of one beam, and which sides are edges; corners of the first end come first."""
    n = sum(loops) + hole
    triangles: list[IntArray] = []
    lines: list[NDArray[np.bool_]] = []

    def add(found: IntArray, edges: tuple[bool, bool, bool] | NDArray[np.bool_]) -> None:
        triangles.append(found)
        lines.append(np.broadcast_to(np.array(edges), found.shape))

    first = 0
    for k in (*loops, *([hole] if hole else [])):
        a = first + np.arange(k)
        b = first + (np.arange(k) + 1) % k
        folded = k < ROUND_CORNERS
        add(np.column_stack([a, b, b + n]), (folded, False, True))
        add(np.column_stack([a, b + n, a + n]), (True, folded, False))
        if not hole:
            fan = np.column_stack([np.full(k - 2, first), a[1:-1], b[1:-1]])
            rims = np.column_stack([np.ones(k - 2), np.arange(k - 2) == k - 3, np.arange(k - 2) == 0])
            for shift in (0, n):
                add(shift + fan, rims.astype(bool))
        first += k
    if hole:
        a, b = np.arange(hole), (np.arange(hole) + 1) % hole
        for shift in (0, n):
            add(shift + np.column_stack([a, b, b + hole]), (False, False, True))
            add(shift + np.column_stack([a, b + hole, a + hole]), (True, False, False))
    return np.concatenate(triangles), np.concatenate(lines)
