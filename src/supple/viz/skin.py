"""The triangles that one sees of a mesh: a shell itself, or the outer faces of a solid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.mesh import CellType, Mesh

IntArray = NDArray[np.int64]

# Corners of the faces, turning about the outward normal.
_TETRA_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
_HEXA_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_FACES = {
    CellType.TRIANGLE3: ((0, 1, 2),),
    CellType.TETRA4: _TETRA_FACES,
    CellType.TETRA10: _TETRA_FACES,
    CellType.HEXA8: _HEXA_FACES,
    CellType.HEXA20: _HEXA_FACES,
}
# A face as its nodes around the rim (corner, mid-edge, corner, ...), cut into triangles.
_CUTS = {
    3: ((0, 1, 2),),
    4: ((0, 1, 2), (0, 2, 3)),
    6: ((0, 1, 5), (1, 2, 3), (3, 4, 5), (1, 3, 5)),
    8: ((0, 1, 7), (1, 2, 3), (3, 4, 5), (5, 6, 7), (1, 3, 7), (3, 5, 7)),
}


def skin_triangles(mesh: Mesh) -> IntArray:
    """Node numbers (T, 3) of the visible triangles, turning about the outward normal on solids.

    Faces that two solid cells share lie inside and are left out; faces with mid-edge nodes are cut at them, so that a
    curved face looks curved.
    """
    return np.concatenate([_cell_skin(kind, cells) for kind, cells in mesh.cells.items()])


def _cell_skin(kind: CellType, cells: IntArray) -> IntArray:
    rims = np.array([_rim(kind, corners) for corners in _FACES[kind]])
    faces = cells[:, rims].reshape(-1, rims.shape[1])
    if kind.dimension == 3:
        _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        faces = faces[np.sort(first[count == 1])]
    return faces[:, np.array(_CUTS[faces.shape[1]])].reshape(-1, 3)


def _rim(kind: CellType, corners: tuple[int, ...]) -> list[int]:
    """Local nodes around a face, with the mid-edge ones where the cell has them."""
    if kind.n_nodes == kind.n_corners:
        return list(corners)
    middle = {frozenset(edge): kind.n_corners + i for i, edge in enumerate(kind.edges)}
    pairs = zip(corners, corners[1:] + corners[:1], strict=True)
    return [node for start, end in pairs for node in (start, middle[frozenset((start, end))])]
