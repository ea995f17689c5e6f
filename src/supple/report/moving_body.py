"""A body in the page: its surface, the axes of its displacements, and its fields over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray, IntArray
from supple.body import BodyForm, RigidBody
from supple.fem import FiniteElementModel
from supple.integrate import FloatingMotion, Motion, Solution
from supple.machine import At, System
from supple.mesh.feature_edges import feature_edges
from supple.quantities import displacement_from_axes, node_positions, observer_of
from supple.report.nodal_shapes import NodalShapes, nodal_shapes
from supple.report.visible_surface import VisibleSurface, surface_of
from supple.results.body_surface import Look, SurfacePoints
from supple.results.colouring import Colouring

DISPLACEMENT_TOLERANCE = 1e-5
"""Allowed error of a displacement by omitted shapes, relative to the largest displacement component."""
FIELD_TOLERANCE = 5e-3
"""Allowed error of a colour field, relative to its largest value; omitted shapes may cause half of it."""
_NUMBERS = 2**21
"""Largest number of displacement components in memory at a time (16 MiB)."""
_FIELD_NUMBERS = 2**24
"""Largest number of values of another field in memory at a time (128 MiB)."""


@dataclass(frozen=True, eq=False)
class MovingBody:
    """The drawn points of a body, `r(t, n) = position + rotation (rest + displacement(t, n))`.

    seen_from : name of the interface that defines the axes of the displacements, or a description of the axes
    rest : (N, 3) undeformed, mesh axes
    node_ids : (N,) id of the node of each point in the mesh file; without a mesh, number of the node; (0,)
        for a rigid body
    surface : triangles of the points, with their lifetimes;   edges : (e, 2) feature edges
    position : (t, 3), rotation : (t, 3, 3)      of the axes of the displacements
    displacement : along these axes; None for a rigid body
    fields : further fields for colours, by name, (t, N, 1)
    unknown : (N,) where fields have no value, such as the stress of a section without recovery points
    """

    name: str
    kind: str
    seen_from: str
    rest: FloatArray
    node_ids: IntArray
    surface: VisibleSurface
    edges: IntArray
    position: FloatArray
    rotation: FloatArray
    displacement: NodalShapes | None = None
    fields: Mapping[str, NodalShapes] = field(default_factory=dict)
    unknown: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=bool))

    @property
    def largest_displacement(self) -> float:
        """The largest magnitude of the displacement, over all points and times."""
        if self.displacement is None:
            return 0.0
        rows = _rows(len(self.position), self.rest.size)
        amplitudes, shapes = self.displacement.amplitudes, self.displacement.shapes
        sizes = (np.linalg.norm(np.tensordot(amplitudes[part], shapes, 1), axis=2) for part in rows)
        return max(float(each.max(initial=0.0)) for each in sizes)

    def positions(self, rows: IntArray) -> FloatArray:
        """Positions (t', N, 3) in space, as drawn in the page, at the times with indices `rows` (t',)."""
        local = self.rest[None]
        if self.displacement is not None:
            local = local + np.tensordot(self.displacement.amplitudes[rows], self.displacement.shapes, 1)
        return self.position[rows, None] + np.einsum("tij,tnj->tni", self.rotation[rows], local)

    def local(self, points: FloatArray) -> FloatArray:
        """Points (t, 3) in space, in the axes of the displacements."""
        return np.einsum("tji,tj->ti", self.rotation, points - self.position)


def moving_body(
    system: System,
    solution: Solution,
    body: BodyForm,
    look: Look | None,
    *,
    colourings: Mapping[str, Colouring],
    bases: Mapping[str, At],
) -> MovingBody:
    """A deformable body in a run; without a mesh its nodes are drawn as points.

    Displacements are relative to the reference interface of deflections. Explicit elements have no frame:
    their displacements are relative to the best-fit axes of the nodes at each time.

    colourings : colourings with values for the body, by name
    bases : reference interfaces of deflections, by body; by default the first interface of the body
    """
    motion = solution.bodies[body.name]
    surface = surface_of(body, look, motion)
    points = surface.points
    rest = points.placed(body.nodes)
    seen = observer_of(system, solution, body.name, bases)
    if seen is None:
        position, rotation = _fitted_axes(body, motion)
        seen_from = "the best-fit axes of its nodes"
    else:
        position = seen.origin - seen.axes @ seen.rest
        rotation = seen.axes
        seen_from = seen.name or "its frame"

    def displacements() -> Iterator[FloatArray]:
        for rows in _rows(len(position), 3 * max(len(rest), len(body.nodes))):
            places = points.positions(body, motion.at(rows))
            yield displacement_from_axes(places, position[rows, None], rotation[rows], rest)

    def values(colouring: Colouring) -> Iterator[FloatArray]:
        # Large blocks of times, because a colouring repeats its preparation of the body at each call.
        for rows in _rows(len(position), len(body.nodes), _FIELD_NUMBERS):
            found = colouring.values(body, motion.at(rows), None)
            assert found is not None
            if found.ndim == 3 and not len(surface.triangles):  # beams as lines
                found = found.max(axis=2)
            for some in _rows(len(found), len(rest)):
                yield np.nan_to_num(points.at_points(found[some]))[..., None]

    mesh = look.mesh if isinstance(look, FiniteElementModel) else look
    return MovingBody(
        body.name,
        body.kind,
        seen_from,
        rest,
        points.nodes if mesh is None else mesh.node_ids[points.nodes],
        surface,
        np.concatenate([surface.lines, feature_edges(rest, surface.triangles)]),
        position,
        rotation,
        nodal_shapes(displacements(), tolerance=DISPLACEMENT_TOLERANCE),
        {
            name: nodal_shapes(values(each), tolerance=0.5 * FIELD_TOLERANCE)
            for name, each in colourings.items()
        },
        points.groups < 0,
    )


def rigid_links(body: RigidBody, motion: Motion, thickness: float) -> MovingBody:
    """A rigid body as bars from its centre of mass to its interfaces, with a block at the centre of mass."""
    own = motion.of_type(FloatingMotion)
    centre = body.centre[None]
    nodes, triangles = _bars(np.broadcast_to(centre, body.nodes.shape), body.nodes, 0.5 * thickness)
    ball, ball_triangles = _bars(centre - thickness / 2, centre + thickness / 2, thickness)
    triangles = np.concatenate([triangles, len(nodes) + ball_triangles])
    nodes = np.concatenate([nodes, ball])
    surface = VisibleSurface(SurfacePoints.of_nodes(np.arange(len(nodes))), triangles)
    edges = feature_edges(nodes, triangles)
    return MovingBody(
        body.name,
        body.kind,
        "its frame",
        nodes,
        np.empty(0, dtype=np.int64),
        surface,
        edges,
        own.position,
        own.rotation,
    )


def _bars(starts: FloatArray, ends: FloatArray, thickness: float) -> tuple[FloatArray, IntArray]:
    """Square bars between points (k, 3), as (8 k, 3) nodes and (12 k, 3) triangles."""
    along = ends - starts
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along = np.where(length > 0, along, [[1.0, 0.0, 0.0]]) / np.where(length > 0, length, 1.0)
    hint = np.eye(3)[np.argmin(np.abs(along), axis=1)]
    first = np.cross(along, hint)
    first *= 0.5 * thickness / np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(along, first)
    around = np.stack([first + second, first - second, -first - second, second - first], axis=1)
    nodes = np.concatenate([starts[:, None] + around, ends[:, None] + around], axis=1)
    corner = np.arange(4)
    after = (corner + 1) % 4
    sides = np.concatenate(
        [np.column_stack([corner, after, after + 4]), np.column_stack([corner, after + 4, corner + 4])]
    )
    one = np.concatenate([sides, [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7)]])
    return nodes.reshape(-1, 3), (8 * np.arange(len(starts))[:, None, None] + one).reshape(-1, 3)


def _fitted_axes(body: BodyForm, motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Origin (t, 3) and axes (t, 3, 3) of the best-fit rigid motion of the undeformed nodes.

    Source: [Kabsch1976]
    """
    centre = body.nodes.mean(axis=0)
    middles, products = [], []
    for rows in _rows(len(motion.arrays()["nodes"]), 3 * len(body.nodes)):
        places = node_positions(body, motion.at(rows))
        middles.append(places.mean(axis=1))
        products.append(np.einsum("tni,nj->tij", places - middles[-1][:, None], body.nodes - centre))
    left, _, right = np.linalg.svd(np.concatenate(products))
    # The nearest rotation, without reflection: for flat bodies the third direction is otherwise undetermined.
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    rotation = left @ right
    return np.concatenate(middles) - rotation @ centre, rotation


def _rows(n_times: int, numbers: int, held: int = _NUMBERS) -> list[slice]:
    """Blocks of successive times, with `numbers` numbers for each time.

    A block has the most times for which it contains at most `held` numbers, but at least eight. The last
    block may have fewer.
    """
    size = max(8, held // max(1, numbers))
    return [slice(start, min(start + size, n_times)) for start in range(0, n_times, size)]
