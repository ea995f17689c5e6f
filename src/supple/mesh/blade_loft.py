"""Blade loft: a shell mesh of skin and two shear webs through the stations of a blade."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import MeshError
from supple.mesh.blade_stations import SHAPE_POINTS, BladeStations
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh
from supple.mesh.structured_grid import alternating_triangles, check_counts, grid_quads

__all__ = ["BladeGrid", "ShearWebs", "loft_blade"]

NARROWEST_PANEL = 0.05
"""Least length of the nose panel and of the aft panel, as a fraction of the chord."""


@dataclass(frozen=True, kw_only=True)
class ShearWebs:
    """Two webs between the skins, at constant distances from the pitch axis along the chord.

    start, end : m, along the span; fore, aft : m from the pitch axis, positive towards the trailing edge.
    """

    start: float
    end: float
    fore: float = -0.3
    aft: float = 0.3

    def __post_init__(self) -> None:
        for field in fields(self):
            if not isfinite(getattr(self, field.name)):
                raise MeshError(f"webs: {field.name} is {getattr(self, field.name)}; give a number")
        if self.start >= self.end:
            raise MeshError(f"webs run from {self.start:g} to {self.end:g}; give an end beyond the start")
        if self.fore >= self.aft:
            raise MeshError(f"webs at {self.fore:g} (fore) and {self.aft:g} (aft); give fore nearer the nose")


@dataclass(frozen=True, kw_only=True)
class BladeGrid:
    """Numbers of cells around each side (nose panel, cap, aft panel), over the webs' depth, along the span.

    `centre_splits` lists the quadrilaterals that are divided about their centre into four triangles instead
    of two. Each is a pair of indices: along the span from the root, and around the ring from the trailing
    edge, lower side first. A split adds one node and two triangles.
    """

    nose_panel: int = 4
    cap: int = 2
    aft_panel: int = 8
    web_depth: int = 3
    root_segments: int = 2
    web_segments: int = 120
    tip_segments: int = 2
    centre_splits: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        check_counts(**{name: value for name, value in vars(self).items() if name != "centre_splits"})
        for segment, panel in self.centre_splits:
            if not (0 <= segment < self.n_segments and 0 <= panel < self.n_around):
                raise MeshError(
                    f"centre split ({segment}, {panel}) lies outside the grid of {self.n_segments} segments "
                    f"and {self.n_around} panels, both counted from 0"
                )

    @property
    def n_around(self) -> int:
        """Nodes of a ring."""
        return 2 * (self.nose_panel + self.cap + self.aft_panel)

    @property
    def n_segments(self) -> int:
        """Segments along the span."""
        return self.root_segments + self.web_segments + self.tip_segments

    @property
    def nose(self) -> int:
        """Index of the leading edge in a ring; the trailing edge has index 0, the lower side comes first."""
        return self.n_around // 2


def loft_blade(stations: BladeStations, webs: ShearWebs, grid: BladeGrid = BladeGrid()) -> Mesh:
    """Triangles on the mid-surfaces of skin and two webs, open at both ends; skin normals point outward.

    Rings of nodes divide three spans into equal steps: root to start of the webs, start to end, end to tip.
    Around a ring, nodes divide each arc between trailing edge, aft web, fore web and leading edge into equal
    parts. The webs are straight between the skins. With `s` segments, `n` nodes around, webs of `w` segments
    and a depth of `d` cells, and no centre splits, there are
        N = n (s + 1) + 2 (w + 1)(d - 1) nodes,   F = 2 n s + 4 w d triangles.

    Returns
    -------
    Mesh   node sets root, tip (rings), leading_edge, trailing_edge (root to tip); cell sets skin, web_fore,
           web_aft; axes as in `BladeStations`
    Raises
    ------
    MeshError   webs beyond root or tip, or outside the section at some span; cells that `Mesh` rejects
    """
    span = _ring_spans(stations, webs, grid)
    skin_nodes = _rings(stations, webs, grid, span)
    rings = np.arange(len(skin_nodes)).reshape(span.size, grid.n_around)
    fore, aft = grid.aft_panel + grid.cap, grid.aft_panel
    with_webs = _web_rings(grid)

    parts, web_grids, n_nodes = [skin_nodes], [], len(skin_nodes)
    for place in (fore, aft):
        lower, upper = rings[with_webs, place], rings[with_webs, grid.n_around - place]
        depth = np.linspace(0, 1, grid.web_depth + 1)[1:-1, None]
        inner = skin_nodes[lower][:, None] * (1 - depth) + skin_nodes[upper][:, None] * depth
        numbers = n_nodes + np.arange(inner.shape[0] * inner.shape[1]).reshape(inner.shape[:2])
        web_grids.append(np.column_stack([lower, numbers, upper]))
        parts.append(inner.reshape(-1, 3))
        n_nodes += numbers.size

    skin, centres = _split_skin(np.column_stack([rings, rings[:, 0]]).T, grid, n_nodes)
    parts.append(skin_nodes[centres].mean(axis=1))
    cells = [skin, *(alternating_triangles(web.T) for web in web_grids)]
    ends = np.cumsum([len(part) for part in cells])
    node_sets = {"root": rings[0], "tip": rings[-1], "leading_edge": rings[:, grid.nose]}
    return Mesh(
        np.vstack(parts),
        {CellType.TRIANGLE3: np.vstack(cells)},
        node_sets | {"trailing_edge": rings[:, 0]},
        {
            name: {CellType.TRIANGLE3: np.arange(end - len(part), end)}
            for name, part, end in zip(("skin", "web_fore", "web_aft"), cells, ends, strict=True)
        },
    )


def _ring_spans(stations: BladeStations, webs: ShearWebs, grid: BladeGrid) -> FloatArray:
    root, tip = stations.span[0], stations.span[-1]
    if not root < webs.start < webs.end < tip:
        raise MeshError(
            f"webs from {webs.start:g} to {webs.end:g} reach beyond the blade, which runs from {root:g} to "
            f"{tip:g}; keep them strictly between root and tip"
        )
    return np.concatenate(
        [
            np.linspace(root, webs.start, grid.root_segments + 1),
            np.linspace(webs.start, webs.end, grid.web_segments + 1)[1:],
            np.linspace(webs.end, tip, grid.tip_segments + 1)[1:],
        ]
    )


def _web_rings(grid: BladeGrid) -> slice:
    """Indices of the rings that the webs reach."""
    return slice(grid.root_segments, grid.root_segments + grid.web_segments + 1)


def _rings(stations: BladeStations, webs: ShearWebs, grid: BladeGrid, span: FloatArray) -> FloatArray:
    """Skin nodes (k * n, 3), ring by ring, from the trailing edge over the lower side to the leading edge."""
    chord, twist, axis, prebend, sweep = stations.curves(span)
    fore, aft = axis + webs.fore / chord, axis + webs.aft / chord
    with_webs = _web_rings(grid)
    outside = with_webs.start + np.flatnonzero(
        (fore[with_webs] < NARROWEST_PANEL) | (aft[with_webs] > 1 - NARROWEST_PANEL)
    )
    if outside.size:
        k = outside[0]
        raise MeshError(
            f"webs outside the section at span {span[k]:g}: x/c = {fore[k]:.3f} (fore) and {aft[k]:.3f} "
            f"(aft) on a chord of {chord[k]:g}; both must lie between {NARROWEST_PANEL} and "
            f"{1 - NARROWEST_PANEL}: shorten the webs, or move them nearer to the pitch axis"
        )
    # At rings without webs, as at a slender tip, nose panel and aft panel have at least NARROWEST_PANEL.
    fore, aft = np.maximum(fore, NARROWEST_PANEL), np.minimum(aft, 1 - NARROWEST_PANEL)
    y = stations.shapes(span)
    x = np.broadcast_to(SHAPE_POINTS, y.shape)
    steps = np.hypot(np.diff(x), np.diff(y))
    arc = np.concatenate([np.zeros((*y.shape[:-1], 1)), np.cumsum(steps, axis=-1)], axis=-1)
    marks = _interpolate_rows(
        x, arc, np.broadcast_to(np.stack([fore, aft], axis=-1)[:, None], (*y.shape[:2], 2))
    )
    at_fore, at_aft = marks[..., :1], marks[..., 1:]
    places = np.concatenate(
        [
            at_fore * _parts(grid.nose_panel),
            at_fore + (at_aft - at_fore) * _parts(grid.cap),
            at_aft + (arc[..., -1:] - at_aft) * _parts(grid.aft_panel),
            arc[..., -1:],
        ],
        axis=-1,
    )
    side_x, side_y = _interpolate_rows(arc, x, places), _interpolate_rows(arc, y, places)
    ring_x = np.concatenate([side_x[:, 0, ::-1], side_x[:, 1, 1:-1]], axis=1)
    ring_y = np.concatenate([side_y[:, 0, ::-1], side_y[:, 1, 1:-1]], axis=1)

    xi, eta = (ring_x - axis[:, None]) * chord[:, None], ring_y * chord[:, None]
    sin, cos = np.sin(twist)[:, None], np.cos(twist)[:, None]
    X, Y = xi * sin + eta * cos + prebend[:, None], xi * cos - eta * sin + sweep[:, None]
    return np.stack([X, Y, np.broadcast_to(span[:, None], X.shape)], axis=-1).reshape(-1, 3)


def _parts(n_cells: int) -> FloatArray:
    """Positions (n_cells,) of the first nodes of equal cells on the interval from 0 to 1."""
    return np.arange(n_cells) / n_cells


def _interpolate_rows(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Interpolate y(x) linearly at `at` (..., k), row by row; x and y (..., p), x ascending in each row."""
    right = np.clip((x[..., None, :] <= at[..., None]).sum(axis=-1), 1, x.shape[-1] - 1)
    x0, x1 = (np.take_along_axis(x, place, axis=-1) for place in (right - 1, right))
    y0, y1 = (np.take_along_axis(y, place, axis=-1) for place in (right - 1, right))
    return y0 + (y1 - y0) * (at - x0) / (x1 - x0)


def _split_skin(around: IntArray, grid: BladeGrid, n_nodes: int) -> tuple[IntArray, IntArray]:
    """Skin triangles, and corners (c, 4) of centre-split quadrilaterals; centres numbered from n_nodes."""
    halves = alternating_triangles(around)
    segment, panel = np.array(grid.centre_splits, dtype=np.int64).reshape(-1, 2).T
    cut = panel * grid.n_segments + segment
    corners = grid_quads(around)[cut]
    centre = np.broadcast_to(n_nodes + np.arange(cut.size)[:, None], corners.shape)
    quarters = np.stack([corners, np.roll(corners, -1, axis=1), centre], axis=-1).reshape(-1, 3)
    kept = np.delete(halves.reshape(-1, 2, 3), cut, axis=0).reshape(-1, 3)
    return np.vstack([kept, quarters]), corners
