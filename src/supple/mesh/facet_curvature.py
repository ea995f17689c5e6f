"""Curvature and sides of the surface represented by a mesh of triangles, from neighbouring triangles."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from supple.arrays import BoolArray, FloatArray, IntArray

CREASE = np.radians(20.0)
"""Largest angle between neighbours on one smooth surface; beyond it their edge is a crease."""
ONE_SURFACE = 0.9
"""Least fraction of the weighted squares of heights that a quadratic fit must explain; below it, a crease."""
SAME_NORMAL = 0.1
"""Differences of normals count as zero up to this fraction of the largest difference nearby."""
FLAT = 1e-6
"""Difference of normals, rad, below which there is no curvature."""
DETERMINED = 1e-3
"""Fraction of the largest eigenvalue of a fit; for lower eigenvalues the curvature component is zero."""

SYMMETRIC = np.array([[[1.0, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]]])


def facet_curvature(nodes: FloatArray, triangles: IntArray, crease: float = CREASE) -> FloatArray:
    """Curvature tensors of the surface through triangles and their neighbours, in global axes.

    The height over the plane of each triangle is `z = 1/2 x^T K x + linear`, zero at the triangle's corners.
    It is fitted to the corners of the neighbours across smooth edges, and of their neighbours, by least
    squares with the weights `1/distance^4`. The fit is exact on a quadratic surface, also at its rim. Among
    equally good fits, the smallest K is used.

    K is zero at creases, where a quadratic surface does not fit the triangle, or does not fit its neighbour
    across a folded edge. K is also zero where a triangle and its surroundings have only two normals: this may
    be a fold of two planes.

    Parameters
    ----------
    nodes : float array (N, 3)      m
    triangles : int array (E, 3)    with an area
    crease : float                  smallest angle of a crease, rad
    Returns
    -------
    float array (E, 3, 3)           1/m, symmetric, in the plane of each triangle; z along its normal
    """
    corners = nodes[triangles]
    first, normal = corners[:, 1] - corners[:, 0], _normals(corners)
    across = sides_across(triangles, normal, crease)
    beside = np.where(across >= 0, across // 3, np.arange(len(across))[:, None])
    bent, folded, edges = _bends(normal, beside)
    K, smooth = np.zeros((len(triangles), 3, 3)), np.zeros(len(triangles), dtype=bool)
    x = first[bent] / np.linalg.norm(first[bent], axis=1, keepdims=True)
    axes = np.stack([x, np.cross(normal[bent], x), normal[bent]], axis=1)
    K[bent], smooth[bent] = _fitted(axes, corners[bent], nodes, _nodes_across(triangles, across)[bent])
    # The surface must continue across an edge where normals differ: the crest of a corrugated sheet does not.
    smooth &= (smooth[beside] | ~edges).all(axis=1)
    shown = smooth & ~folded
    for _ in range(2):
        shown |= shown[beside].any(axis=1)
    K[~(smooth & shown)] = 0.0
    return K


def sides_across(triangles: IntArray, normals: FloatArray, crease: float) -> IntArray:
    """For each side (E, 3), the number 3 e + k of side k of its neighbour e; -1 at rims and creases.

    Side k goes from corner k to the next. Of several triangles at an edge, the two with the least angle are
    neighbours.

    normals : float array (E, 3)    right-handed to the order of the corners
    crease : float                  rad
    """
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    edge = np.minimum(start, end) * (int(triangles.max(initial=0)) + 1) + np.maximum(start, end)
    order = np.argsort(edge, kind="stable")
    across, best = np.full(edge.size, -1), np.full(edge.size, np.cos(crease))
    for shift in range(1, int(np.unique(edge, return_counts=True)[1].max(initial=1))):
        same = edge[order[shift:]] == edge[order[:-shift]]
        pair = order[:-shift][same], order[shift:][same]
        # Triangles of equal orientation run along their common edge in opposite directions.
        sense = np.where(start[pair[0]] == end[pair[1]], 1.0, -1.0)
        cosine = sense * (normals[pair[0] // 3] * normals[pair[1] // 3]).sum(axis=1)
        for side, other in (pair, pair[::-1]):
            closer = cosine > best[side]
            across[side[closer]], best[side[closer]] = other[closer], cosine[closer]
    mutual = (across >= 0) & (across[across] == np.arange(edge.size))
    return np.where(mutual, across, -1).reshape(-1, 3)


def _normals(corners: FloatArray) -> FloatArray:
    """Unit normals (E, 3) of triangles with these corners (E, 3, 3)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _nodes_across(triangles: IntArray, across: IntArray) -> IntArray:
    """Nodes (E, 12) opposite the sides of each triangle and of its neighbours; -1 where there is none."""
    beyond = np.where(across >= 0, triangles.ravel()[across - across % 3 + (across + 2) % 3], -1)
    further = np.where(across[..., None] >= 0, beyond[across // 3], -1)
    return np.concatenate([beyond, further.reshape(len(triangles), -1)], axis=1)


def _quadratics(points: FloatArray) -> FloatArray:
    """Heights (..., 3) of unit curvatures xx, yy, xy."""
    x, y = points[..., 0], points[..., 1]
    return np.stack([0.5 * x**2, 0.5 * y**2, x * y], axis=-1)


def _linear(points: FloatArray) -> FloatArray:
    """x, y, 1 of points, (..., 3)."""
    return np.concatenate([points[..., :2], np.ones((*points.shape[:-1], 1))], axis=-1)


def _bends(normal: FloatArray, beside: IntArray) -> tuple[BoolArray, BoolArray, BoolArray]:
    """Whether the normals near each triangle differ (E,), and whether at most two different ones occur (E,).

    Near a triangle are its neighbours and their neighbours. The third mask (E, 3) marks the sides across
    which the normals differ.
    """
    near = np.concatenate([beside, beside[beside].reshape(len(beside), -1)], axis=1)
    # Triangles of opposite orientation have the opposite normal.
    sense = np.sign((normal[near] * normal[:, None]).sum(axis=2, keepdims=True))
    turned = sense * normal[near] - normal[:, None]
    squares = (turned**2).sum(axis=2)
    most = np.take_along_axis(turned, squares.argmax(axis=1)[:, None, None], axis=1)
    off = np.minimum(squares, ((turned - most) ** 2).sum(axis=2)).max(axis=1)
    largest = squares.max(axis=1)
    same = SAME_NORMAL**2 * largest
    return largest > FLAT**2, off <= same, squares[:, :3] > same[:, None]


def _fitted(
    axes: FloatArray, corners: FloatArray, nodes: FloatArray, around: IntArray
) -> tuple[FloatArray, BoolArray]:
    """Curvature (E, 3, 3) of the surface through corners (E, 3, 3) and nodes around, and whether it fits."""
    scale = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)[:, None, None]
    origin = corners.mean(axis=1, keepdims=True)
    own, near = ((each - origin) @ axes.swapaxes(1, 2) / scale for each in (corners, nodes[around]))
    rows = _quadratics(near) - _linear(near) @ np.linalg.solve(_linear(own), _quadratics(own))
    distance = np.linalg.norm(near, axis=2)
    weight = np.divide(1.0, distance**4, out=np.zeros_like(distance), where=around >= 0)
    values, explained = _smallest_fit(rows, near[..., 2], weight)
    K = np.einsum("ec,cij->eij", values, SYMMETRIC) / scale
    return axes[:, :2].swapaxes(1, 2) @ K @ axes[:, :2], explained > ONE_SURFACE


def _smallest_fit(rows: FloatArray, wanted: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (E, c) of least weighted squares of `rows . values - wanted`, and the explained share (E,).

    The values are the smallest of all equally good fits. The explained share is the fraction of the weighted
    squares of `wanted` that the fit reproduces.
    """
    weighted = (rows * weight[..., None]).swapaxes(1, 2)
    eigenvalues, vectors = np.linalg.eigh(weighted @ rows)
    shown = eigenvalues > DETERMINED * eigenvalues[:, -1:]
    inverse = np.divide(1.0, eigenvalues, out=np.zeros_like(eigenvalues), where=shown)
    right = (weighted @ wanted[..., None])[..., 0]
    values = np.einsum("eij,ej,ekj,ek->ei", vectors, inverse, vectors, right)
    squares = (weight * wanted**2).sum(axis=1)
    fitted = (values * right).sum(axis=1)
    return values, np.divide(fitted, squares, out=np.zeros_like(squares), where=squares > 0)


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
    across = sides_across(triangles, _normals(nodes[triangles]), crease).ravel()
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
