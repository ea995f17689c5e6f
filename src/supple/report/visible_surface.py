"""What is seen of a body: triangles of some of its nodes, and from when to when each of them is there."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.body import BodyForm
from supple.mesh import Mesh, skin_of
from supple.mesh.outer_faces import FACE_TRIANGLES

__all__ = ["VisibleSurface", "surface_of"]

IntArray = NDArray[np.int64]


def _none(columns: int) -> IntArray:
    return np.empty((0, columns), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class VisibleSurface:
    """Triangles and lines; bare points where a body has neither.

    nodes : (N,) numbers of the body's nodes that are drawn
    triangles : (m, 3), lines : (k, 2)       of these N
    lifetimes : (m, 2) first instant at which a triangle is there, and first at which it is not any more;
        None where all are there throughout
    """

    nodes: IntArray
    triangles: IntArray
    lines: IntArray = field(default_factory=lambda: _none(2))
    lifetimes: IntArray | None = None


def surface_of(body: BodyForm, mesh: Mesh | None, motion: Any) -> VisibleSurface:
    """The skin of a mesh, of which elements may be deleted, and its beams; without a mesh all nodes."""
    alive = motion.arrays().get("alive")
    if alive is not None and not np.all(alive):
        return _eroding_surface(body, alive)
    if mesh is None:
        return VisibleSurface(np.arange(len(body.nodes)), _none(3))
    lines = [cells[:, :2] for kind, cells in mesh.cells.items() if kind.dimension == 1]
    has_faces = any(kind.dimension > 1 for kind in mesh.cells)
    return _of_used_nodes(
        skin_of(mesh).triangles if has_faces else _none(3), np.concatenate([_none(2), *lines])
    )


def _of_used_nodes(triangles: IntArray, lines: IntArray, lifetimes: IntArray | None = None) -> VisibleSurface:
    nodes, own = np.unique(np.concatenate([triangles.ravel(), lines.ravel()]), return_inverse=True)
    first, second = np.split(own.ravel(), [triangles.size])
    return VisibleSurface(nodes, first.reshape(-1, 3), second.reshape(-1, 2), lifetimes)


def _eroding_surface(body: Any, alive: NDArray[np.float64]) -> VisibleSurface:
    """Faces of elements (t, E) that are alive or not: a face is seen while just one of its elements is.

    A face between two elements appears when the first of them is deleted, and goes with the second.
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
    # A face has as many triangles of one element as of its neighbour; one of each is drawn.
    per_face = np.where(all_keys[:, -1] >= 0, 2, 1)
    shared = elements[face] > per_face
    born = np.where(shared, first[face], 0)
    dies = last[face]
    seen = (born < dies) & (~shared | (all_deaths == dies))
    lifetimes = np.column_stack([born[seen], dies[seen]])
    return _of_used_nodes(all_triangles[seen], _none(2), lifetimes)


def _face_keys(kind: Any, cells: IntArray) -> IntArray:
    """Sorted corners (m, 4) of the face that each of `FACE_TRIANGLES` is of, -1 as a fourth."""
    keys = []
    for corners in kind.faces:
        own = np.sort(cells[:, corners], axis=1)
        own = np.hstack([own, np.full((len(own), 4 - own.shape[1]), -1)])
        keys += [own] * (len(corners) - 2)
    return np.stack(keys, axis=1).reshape(-1, 4)
