"""Quadrilaterals of a file, as triangles, since the mesh has no quadrilaterals."""

from __future__ import annotations

import numpy as np

from supple.arrays import BoolArray, FloatArray, IntArray

CROSSED = "its sides cross; list its nodes in their order around it"
"""The error message for a crossed quadrilateral."""

_ALONG_02, _ALONG_13 = [[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]


def split_quadrilaterals(nodes: FloatArray, quads: IntArray) -> IntArray:
    """Two triangles (2 Q, 3) for each quadrilateral (Q, 4), cut along the shorter diagonal inside it.

    Triangles 2 q and 2 q + 1 come from quadrilateral q and have the same orientation.
    """
    corners = nodes[quads]
    diagonal_02 = np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1)
    diagonal_13 = np.linalg.norm(corners[:, 3] - corners[:, 1], axis=1)
    inside_02, inside_13 = _same_orientation(corners, _ALONG_02), _same_orientation(corners, _ALONG_13)
    take_02 = inside_02 & ((diagonal_02 <= diagonal_13) | ~inside_13)
    return np.where(take_02[:, None, None], quads[:, _ALONG_02], quads[:, _ALONG_13]).reshape(-1, 3)


def split_quadratic_surfaces(nodes: FloatArray, surfaces: IntArray) -> IntArray:
    """Triangles over all nodes of six-node triangles (4 each) or eight-node quadrilaterals (6 each).

    Corners come first, then the middle nodes of the edges in order. Each corner forms a triangle with the
    middle nodes beside it. The quadrilateral of four middle nodes is split along its shorter diagonal.
    """
    n = surfaces.shape[1] // 2
    corners = [(i, n + i, n + (i - 1) % n) for i in range(n)]
    outer = surfaces[:, corners]
    middles = surfaces[:, n:]
    inner = split_quadrilaterals(nodes, middles).reshape(-1, 2, 3) if n == 4 else middles[:, None]
    return np.concatenate([outer, inner], axis=1).reshape(-1, 3)


def crossed_quadrilaterals(nodes: FloatArray, quads: IntArray) -> IntArray:
    """Numbers (k,) of the quadrilaterals that no diagonal cuts into triangles of the same orientation."""
    corners = nodes[quads]
    return np.flatnonzero(~_same_orientation(corners, _ALONG_02) & ~_same_orientation(corners, _ALONG_13))


def _same_orientation(corners: FloatArray, triangles: list[list[int]]) -> BoolArray:
    """Whether the normals of both triangles point to the same side."""
    x = corners[:, triangles]
    normals = np.cross(x[:, :, 1] - x[:, :, 0], x[:, :, 2] - x[:, :, 0])
    return np.einsum("ei,ei->e", normals[:, 0], normals[:, 1]) >= 0
