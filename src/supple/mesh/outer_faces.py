"""Outer faces of a mesh, also as triangles, oriented by their outward normals."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from supple.arrays import IntArray
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh

FACE_TRIANGLES = {
    kind: np.array([(face[0], *pair) for face in kind.faces for pair in pairwise(face[1:])])
    for kind in CellType
    if kind.faces
}
"""Local corner numbers of the triangles into which the faces of each cell type are divided."""


def outer_faces(mesh: Mesh, *, middles: bool = False) -> list[IntArray]:
    """Outer faces of all cells: arrays (F, k) of faces with k nodes, each oriented by its outward normal.

    Faces shared by two solid cells, of one type or two, are interior and left out. The faces of a shell are
    its triangles.

    middles : whether to include the mid-edge nodes of quadratic cells, between the corners
    """
    found: list[IntArray] = []
    for size in (3, 4):
        rows: list[tuple[IntArray, IntArray]] = []
        for kind, cells in mesh.cells.items():
            corners = [face for face in kind.faces if len(face) == size]
            if not corners:
                continue
            rims = [_rim(kind, face) for face in corners] if middles else corners
            faces = cells[:, rims].reshape(-1, len(rims[0]))
            if kind.dimension == 3:
                rows.append((np.sort(cells[:, corners].reshape(-1, size), axis=1), faces))
            else:
                found.append(faces)
        if rows:
            keys = np.concatenate([key for key, _ in rows])
            _, own, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
            ends = np.cumsum([len(key) for key, _ in rows])[:-1]
            once = np.split(count[own.ravel()] == 1, ends)
            found += [faces[outer] for (_, faces), outer in zip(rows, once, strict=True)]
    return found


def is_shell(mesh: Mesh) -> bool:
    """Whether the faces of a mesh are those of shells, which have two sides."""
    return all(kind.dimension < 3 for kind in mesh.cells)


def outer_triangles(mesh: Mesh, nodes: IntArray) -> IntArray:
    """Triangles (T, 3) of the outer faces with all corners among some nodes; (0, 3) if there are none."""
    wanted = np.zeros(mesh.n_nodes, dtype=bool)
    wanted[nodes] = True
    found = [np.empty((0, 3), dtype=np.int64)]
    for faces in outer_faces(mesh):
        inside = faces[wanted[faces].all(axis=1)]
        cuts = [(0, 1, 2)] if faces.shape[1] == 3 else [(0, 1, 2), (0, 2, 3)]
        found += [inside[:, cut] for cut in cuts]
    return np.concatenate(found)


def _rim(kind: CellType, corners: tuple[int, ...]) -> list[int]:
    """Local nodes around a face, with the mid-edge ones where the cell has them."""
    middles = kind.middles(corners)
    return [node for pair in zip(corners, middles, strict=True) for node in pair] if middles else [*corners]
