"""Feature edges of a surface: rims, folds and silhouette."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from supple.arrays import FloatArray, IntArray


def feature_edges(
    nodes: FloatArray, triangles: IntArray, *, fold_angle: float = np.radians(30.0)
) -> IntArray:
    """Edges (k, 2) of one triangle only, or between two triangles at an angle above the fold angle.

    Where more than two triangles meet, an inner wall joins the skin, and the edge is not part of the outer
    shape.
    """
    sides = _sides(triangles)
    normal = _normals(nodes, triangles)
    total = np.stack([np.bincount(sides.edge, normal[sides.owner, i], len(sides.edges)) for i in range(3)])
    # The sum of two unit normals at an angle phi has the length 2 cos(phi / 2).
    folded = np.linalg.norm(total, axis=0) < 2.0 * np.cos(0.5 * fold_angle)
    return sides.edges[(sides.count == 1) | ((sides.count == 2) & folded)]


def silhouette_edges(nodes: FloatArray, triangles: IntArray, towards: FloatArray) -> IntArray:
    """Edges (k, 2) between two triangles of which one faces the viewer and one does not.

    towards : (3,) direction of the viewer, at infinity. Triangles may have any orientation.
    """
    sides = _sides(triangles)
    facing = np.sign(_normals(nodes, triangles) @ towards)
    # Triangles of equal orientation run along their common edge in opposite senses.
    seen = np.bincount(sides.edge, sides.sense * facing[sides.owner], len(sides.edges))
    return sides.edges[(sides.count == 2) & (np.abs(seen) == 2)]


class _Sides(NamedTuple):
    """The distinct edges of triangles, and the three sides of every triangle, each on one of these edges.

    edges : (e, 2);  count : (e,) number of triangles at each edge
    edge, owner, sense : (3 T,) edge and triangle of each side; 1 if it runs to the higher node number, or -1
    """

    edges: IntArray
    count: IntArray
    edge: IntArray
    owner: IntArray
    sense: IntArray


def _sides(triangles: IntArray) -> _Sides:
    pairs = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges, edge, count = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True, return_counts=True)
    sense = np.where(pairs[:, 0] < pairs[:, 1], 1, -1)
    return _Sides(edges, count, edge, np.repeat(np.arange(len(triangles)), 3), sense)


def _normals(nodes: FloatArray, triangles: IntArray) -> FloatArray:
    corners = nodes[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
