"""The sides of a wall of triangles, whose normals may point to both sides."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.mesh.facet_curvature import sides_across

SMOOTH = np.radians(60.0)
"""Largest angle between neighbours of one wall; plates that meet at a larger angle are separate walls."""


def turned_over(nodes: FloatArray, triangles: IntArray, *, crease: float = SMOOTH) -> BoolArray:
    """Whether the normal of each triangle (E,) points to the other side than most normals of its wall.

    A wall is a set of triangles that meet at smooth edges. If equally many normals point to both sides, the
    first triangle determines the side. In a wall with one side, such as a Moebius strip, none is turned over.

    nodes : float array (N, 3)
    triangles : int array (E, 3)    with an area
    crease : float                  largest angle between neighbours of one wall, rad
    """
    corners = nodes[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    across = sides_across(triangles, normals, crease).ravel()
    side = np.flatnonzero(across >= 0)
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    # Triangles of equal orientation run along their common edge in opposite directions.
    alike = start[side] == end[across[side]]
    if alike.all():
        return np.zeros(len(triangles), dtype=bool)
    # Each triangle is in the graph twice, as it is and turned over; what is connected has one orientation.
    n, own, other = len(triangles), side // 3, across[side] // 3
    rows, columns = np.concatenate([own, own + n]), np.concatenate([other + n * ~alike, other + n * alike])
    graph = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(2 * n, 2 * n))
    _, labels = connected_components(graph, directed=False)
    as_is, over = labels[:n], labels[n:]
    wall, turned = np.minimum(as_is, over), as_is > over
    number = np.bincount(wall, minlength=2 * n)
    most_are = np.bincount(wall, turned, minlength=2 * n) > number / 2
    return (turned != most_are[wall]) & (as_is != over)
