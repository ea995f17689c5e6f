"""Outer faces of a mesh as triangles that turn about their outward normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.mesh import CellType, Mesh

__all__ = ["FACE_TRIANGLES", "outer_triangles"]

IntArray = NDArray[np.int64]

_TETRA_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
_HEXA_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_CUT_HEXA_FACES = tuple(t for a, b, c, d in _HEXA_FACES for t in ((a, b, c), (a, c, d)))

FACE_TRIANGLES = {
    CellType.TRIANGLE3: np.array([(0, 1, 2)]),
    CellType.TETRA4: np.array(_TETRA_FACES),
    CellType.TETRA10: np.array(_TETRA_FACES),
    CellType.HEXA8: np.array(_CUT_HEXA_FACES),
    CellType.HEXA20: np.array(_CUT_HEXA_FACES),
}
"""Corners of the triangles that make the faces of a cell."""

_RIMS = {
    CellType.TRIANGLE3: np.array([(0, 1, 2)]),
    CellType.TETRA4: np.array(_TETRA_FACES),
    CellType.TETRA10: np.array(_TETRA_FACES),
    CellType.HEXA8: np.array(_HEXA_FACES),
    CellType.HEXA20: np.array(_HEXA_FACES),
}


def outer_triangles(mesh: Mesh, nodes: IntArray) -> IntArray:
    """Triangles (T, 3) of the outer faces all of whose corners are among some nodes; none is (0, 3).

    Faces that two solid cells share lie inside; a shell has the side that its triangles turn about.
    """
    wanted = np.zeros(mesh.n_nodes, dtype=bool)
    wanted[nodes] = True
    found = [np.empty((0, 3), dtype=np.int64)]
    for kind, cells in mesh.cells.items():
        if kind not in _RIMS:
            continue
        faces = cells[:, _RIMS[kind]].reshape(-1, _RIMS[kind].shape[1])
        if kind.dimension == 3:
            _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
            faces = faces[np.sort(first[count == 1])]
        faces = faces[wanted[faces].all(axis=1)]
        cuts = [(0, 1, 2)] if faces.shape[1] == 3 else [(0, 1, 2), (0, 2, 3)]
        found += [faces[:, cut] for cut in cuts]
    return np.concatenate(found)
