"""The visible surface of a body in the page: triangles and lines, with their lifetimes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.arrays import IntArray
from supple.body import BodyForm
from supple.fem import FiniteElementModel
from supple.integrate import Motion
from supple.mesh import CellType
from supple.mesh.outer_faces import FACE_TRIANGLES
from supple.results.body_surface import Look, SurfacePoints, body_surface


def _none(columns: int) -> IntArray:
    return np.empty((0, columns), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class VisibleSurface:
    """Triangles and lines; points for a body without either.

    points : N points: the drawn points, and the nodes to which they are attached
    triangles : (m, 3), lines : (k, 2)       of the N points
    lifetimes : (m, 2) first time index at which a triangle exists, and first index at which it no longer
        exists; None if all triangles exist throughout
    """

    points: SurfacePoints
    triangles: IntArray
    lines: IntArray = field(default_factory=lambda: _none(2))
    lifetimes: IntArray | None = None

    @property
    def carriers(self) -> IntArray:
        """(N,) for each point, the index in `points` of the node to which it is attached."""
        # Nodes come before the points attached to them.
        _, first, own = np.unique(self.points.nodes, return_index=True, return_inverse=True)
        return first[own]


def surface_of(body: BodyForm, look: Look | None, motion: Motion) -> VisibleSurface:
    """The visible surface of a body, with lifetimes if elements are deleted; without a mesh, all nodes.

    Beams are drawn with their sections if their elements are given, otherwise as lines; springs and ties are
    lines.
    """
    alive = motion.arrays().get("alive")
    if alive is not None and not np.all(alive):
        return _eroding_surface(body, alive)
    if look is None:
        return VisibleSurface(SurfacePoints.of_nodes(np.arange(len(body.nodes))), _none(3))
    mesh = look.mesh if isinstance(look, FiniteElementModel) else look
    has_sections = isinstance(look, FiniteElementModel) and CellType.LINE2 in mesh.cells
    if not (has_sections or any(kind.dimension > 1 for kind in mesh.cells)):
        points, triangles, lines = SurfacePoints.of_nodes(np.arange(mesh.n_nodes)), _none(3), [mesh.links]
    else:
        surface = body_surface(look)
        points, triangles, lines = surface, surface.skin.triangles, [surface.links]
    if not has_sections:
        lines += [cells[:, :2] for kind, cells in mesh.cells.items() if kind.dimension == 1]
    return _of_used_points(points, triangles, np.concatenate(lines))


def _of_used_points(
    points: SurfacePoints, triangles: IntArray, lines: IntArray, lifetimes: IntArray | None = None
) -> VisibleSurface:
    """A surface of the used points alone, in the order of their numbers, so that nodes come first."""
    drawn = np.concatenate([triangles.ravel(), lines.ravel()])
    used = np.union1d(drawn, points.nodes[drawn])
    first, second = np.split(np.searchsorted(used, drawn), [triangles.size])
    return VisibleSurface(points.some(used), first.reshape(-1, 3), second.reshape(-1, 2), lifetimes)


def _eroding_surface(body: Any, alive: NDArray[np.float64]) -> VisibleSurface:
    """Surface of elements, some of them deleted: a face is visible while exactly one of its elements exists.

    alive : (t, E) whether each element exists

    A face between two elements appears when the first of them is deleted, and disappears with the second.
    """
    n_times = len(alive)
    death = np.where(np.all(alive, axis=0), n_times, np.argmin(alive, axis=0))
    triangles, keys, deaths, start = [], [], [], 0
    for section in body.model.sections:
        kind, cells = section.cell_type, body.mesh.cells[section.cell_type][section.cells]
        corners = cells[:, FACE_TRIANGLES[kind]].reshape(-1, 3)
        own = np.repeat(death[start : start + len(cells)], len(FACE_TRIANGLES[kind]))
        start += len(cells)
        triangles.append(corners)
        deaths.append(own)
        keys.append(_face_keys(kind, cells))
    all_triangles, all_deaths, all_keys = (np.concatenate(each) for each in (triangles, deaths, keys))
    _, face = np.unique(all_keys, axis=0, return_inverse=True)
    face = face.ravel()
    first = np.full(face.max() + 1, n_times)
    last = np.zeros(face.max() + 1, dtype=np.int64)
    np.minimum.at(first, face, all_deaths)
    np.maximum.at(last, face, all_deaths)
    elements = np.zeros(face.max() + 1, dtype=np.int64)
    np.add.at(elements, face, 1)
    # A shared face has the triangles of both its elements; the triangles of one element are drawn.
    per_face = np.where(all_keys[:, -1] >= 0, 2, 1)
    shared = elements[face] > per_face
    born = np.where(shared, first[face], 0)
    dies = last[face]
    seen = (born < dies) & (~shared | (all_deaths == dies))
    lifetimes = np.column_stack([born[seen], dies[seen]])
    points = SurfacePoints.of_nodes(np.arange(len(body.nodes)))
    return _of_used_points(points, all_triangles[seen], _none(2), lifetimes)


def _face_keys(kind: CellType, cells: IntArray) -> IntArray:
    """Sorted corners (m, 4) of the face of each triangle of `FACE_TRIANGLES`; -1 if there is no fourth."""
    keys = []
    for corners in kind.faces:
        own = np.sort(cells[:, corners], axis=1)
        own = np.hstack([own, np.full((len(own), 4 - own.shape[1]), -1)])
        keys += [own] * (len(corners) - 2)
    return np.stack(keys, axis=1).reshape(-1, 4)
