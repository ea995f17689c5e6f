"""Feature edges of a surface: rims, folds and silhouette."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray, IntArray

FOLD_ANGLE = np.radians(30.0)


def feature_edges(nodes: FloatArray, triangles: IntArray) -> IntArray:
    """Edges (k, 2) of one triangle only, or between two triangles at an angle above FOLD_ANGLE.

    Where more than two triangles meet, an inner wall joins the skin, and the edge is not part of the outer
    shape.
    """
    edges, count, edge, owner, _ = _sides(triangles)
    normal = _normals(nodes, triangles)
    total = np.stack([np.bincount(edge, normal[owner, i], len(edges)) for i in range(3)])
    # The sum of two unit normals at an angle phi has the length 2 cos(phi / 2).
    folded = np.linalg.norm(total, axis=0) < 2.0 * np.cos(0.5 * FOLD_ANGLE)
    return edges[(count == 1) | ((count == 2) & folded)]


def silhouette_edges(nodes: FloatArray, triangles: IntArray, towards: FloatArray) -> IntArray:
    """Edges (k, 2) between two triangles of which one faces the viewer and one does not.

    towards : (3,) direction of the viewer, at infinity. Triangles may have any orientation.
    """
    edges, count, edge, owner, sense = _sides(triangles)
    facing = np.sign(_normals(nodes, triangles) @ towards)
    # Triangles of equal orientation run along their common edge in opposite senses.
    seen = np.bincount(edge, sense * facing[owner], len(edges))
    return edges[(count == 2) & (np.abs(seen) == 2)]


def _sides(triangles: IntArray) -> tuple[IntArray, IntArray, IntArray, IntArray, IntArray]:
    """The distinct edges (e, 2) of triangles with their numbers of triangles (e,), and all sides (3 T,).

    The last three arrays are the edge and the triangle of each side, and its sense: 1 if it runs to the
    higher node number, or -1.
    """
    pairs = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges, edge, count = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True, return_counts=True)
    sense = np.where(pairs[:, 0] < pairs[:, 1], 1, -1)
    return edges, count, edge, np.repeat(np.arange(len(triangles)), 3), sense


def _normals(nodes: FloatArray, triangles: IntArray) -> FloatArray:
    corners = nodes[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
