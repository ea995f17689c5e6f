"""Outer faces of a mesh as triangles that turn about their outward normals."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.mesh import CellType, Mesh

__all__ = ["FACE_TRIANGLES", "outer_faces", "outer_triangles"]

IntArray = NDArray[np.int64]

FACE_TRIANGLES = {
    kind: np.array([(face[0], *pair) for face in kind.faces for pair in pairwise(face[1:])])
    for kind in CellType
    if kind.faces
}
"""Corners of the triangles that make the faces of a cell."""


def outer_faces(kind: CellType, cells: IntArray, rims: ArrayLike) -> IntArray:
    """Faces (F, k) of cells (n, m) of a kind; those that two solid cells share lie inside and are left out.

    rims : (f, k)   nodes of each face of a cell, corners alone or mid-edge nodes too
    """
    faces = cells[:, np.asarray(rims)].reshape(-1, np.shape(rims)[1])
    if kind.dimension != 3:
        return faces
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def outer_triangles(mesh: Mesh, nodes: IntArray) -> IntArray:
    """Triangles (T, 3) of the outer faces all of whose corners are among some nodes; none is (0, 3).

    Faces that two solid cells share lie inside; a shell has the side that its triangles turn about.
    """
    wanted = np.zeros(mesh.n_nodes, dtype=bool)
    wanted[nodes] = True
    found = [np.empty((0, 3), dtype=np.int64)]
    for kind, cells in mesh.cells.items():
        if not kind.faces:
            continue
        faces = outer_faces(kind, cells, kind.faces)
        faces = faces[wanted[faces].all(axis=1)]
        cuts = [(0, 1, 2)] if faces.shape[1] == 3 else [(0, 1, 2), (0, 2, 3)]
        found += [faces[:, cut] for cut in cuts]
    return np.concatenate(found)
