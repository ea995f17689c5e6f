"""The edges that tell a shape: where a surface ends and where it folds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]


def feature_edges(
    nodes: NDArray[np.float64], triangles: IntArray, *, fold_angle: float = np.radians(30.0)
) -> IntArray:
    """Edges (k, 2) that one triangle has alone, or at which two meet at an angle above the fold angle.

    Where more than two meet, an inner wall joins the skin, and its edge is none of the outer shape.
    """
    pairs = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, inverse, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    corners = nodes[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    owner = np.repeat(np.arange(len(triangles)), 3)
    total = np.stack([np.bincount(inverse, normal[owner, i], len(edges)) for i in range(3)])
    # Two unit normals at an angle phi add up to the length 2 cos(phi / 2).
    folded = np.linalg.norm(total, axis=0) < 2.0 * np.cos(0.5 * fold_angle)
    return edges[(count == 1) | ((count == 2) & folded)]
