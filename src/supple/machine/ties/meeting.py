"""Points of a mesh that match given nodes: nodes of the mesh, or points on its faces."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.mesh import Mesh
from supple.mesh.outer_faces import FACE_TRIANGLES


def meeting_nodes(points: FloatArray, nodes: FloatArray, within: float) -> IntArray:
    """Numbers (n,) of the nodes (N, 3) nearest to points (n, 3); -1 where none is at most `within` away."""
    distance, nearest = KDTree(nodes).query(points)
    return np.where(distance <= within, nearest, -1)


def on_faces(points: FloatArray, mesh: Mesh, within: float, what: str) -> tuple[IntArray, FloatArray]:
    """Corners (n, 3) of the nearest face triangle to each point (n, 3), and their weights, with the sum one.

    Weights (n, 3) are linear on triangles, so linear displacements are transferred exactly.
    Raises ModelError where a point is farther than `within` from every face: the interfaces do not match.
    """
    triangles = np.concatenate(
        [
            cells[:, FACE_TRIANGLES[kind]].reshape(-1, 3)
            for kind, cells in mesh.cells.items()
            if kind in FACE_TRIANGLES
        ]
    )
    corners = mesh.nodes[triangles]
    # The centre of the nearest face is at most the largest face size plus `within` away from the point.
    centres, reach = corners.mean(axis=1), np.linalg.norm(np.ptp(corners, axis=1), axis=1).max()
    tree = KDTree(centres)
    found, weights = np.empty((len(points), 3), dtype=np.int64), np.empty((len(points), 3))
    for number, (point, near) in enumerate(
        zip(points, tree.query_ball_point(points, reach + within), strict=True)
    ):
        gaps, own = _gaps(point, corners[near]) if near else (np.array([np.inf]), np.zeros((1, 3)))
        best = int(np.argmin(gaps))
        if gaps[best] > within:
            raise ModelError(
                f"{what}: the node at {np.array2string(point, precision=6)} does not match the other part; "
                f"the nearest face is {gaps[best]:.3g} away, at most {within:.3g} is allowed. Check the "
                "positions of the parts; `within` allows a larger distance"
            )
        found[number], weights[number] = triangles[near[best]], own[best]
    return found, weights


def _gaps(point: FloatArray, corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (t,) of a point from its projections onto triangles (t, 3, 3), and area coordinates (t, 3).

    The area coordinates are those of the projections, which are limited to the triangles.
    """
    edges = corners[:, 1:] - corners[:, :1]
    gram = np.einsum("tai,tbi->tab", edges, edges)
    right = np.einsum("tai,ti->ta", edges, point - corners[:, 0])
    inner = np.linalg.solve(gram, right[..., None])[..., 0]
    weights = np.clip(np.column_stack([1 - inner.sum(axis=1), inner]), 0.0, None)
    weights /= weights.sum(axis=1, keepdims=True)
    return np.linalg.norm(np.einsum("ta,tai->ti", weights, corners) - point, axis=1), weights
