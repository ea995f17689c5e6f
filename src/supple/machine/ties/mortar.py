"""Mortar tie of different meshes: mean positions, weighted by dual functions of the tied side, are equal.

    int psi_i (x_tied - x) dA = 0   ->   x_i = sum_m (int psi_i N_m dA / int N_i dA) x_m

with linear shape functions N_i of the tied side, N_m of the other side, and dual functions psi_i = 4 N_i - 1
on each triangle of the tied side, which are biorthogonal to N_j (int psi_i N_j dA = delta_ij int N_i dA).
Each node follows corners near it; no system of equations is solved. Both integrals are exact: faces are cut
along the edges of the other side. Therefore linear displacements are transferred exactly to the tied side,
and constant tractions exactly to the other side.

B. Wohlmuth, SIAM J. Numer. Anal. 38 (2000) 989-1012, on dual Lagrange multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import KDTree

from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.mesh import Mesh
from supple.mesh.outer_faces import outer_triangles

__all__ = ["Mortar"]

_INSIDE = 1e-12  # in area coordinates: tolerance for points on an edge of a triangle
_COVERED = 1e-6  # largest fraction of a face's area that may lack a match on the other side
_MIDDLES = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]])
"""Mid-side points of a triangle: equal weights there integrate polynomials of second degree exactly."""


@dataclass(frozen=True)
class Mortar:
    """Each node follows a weighted mean of the other mesh over the faces at the node, by exact integrals.

    The other mesh must cover the faces of the tied side. Faces must have straight sides and corner nodes
    only. The two sides may be apart, for curved surfaces, by at most `Tie.within`.
    """

    def weights(
        self, points: FloatArray, faces: IntArray, mesh: Mesh, within: float, what: str
    ) -> tuple[IntArray, FloatArray]:
        """Nodes (n, c) of a mesh that points (n, 3) follow, and their weights (n, c), one in sum per point.

        faces : (T, 3) triangles of the tied side, as indices of `points`
        within : largest distance between the sides, m
        what : name of the tie in messages
        Raises ModelError for points that are not corners of a face, and faces that the mesh does not cover.
        """
        alone = np.setdiff1d(np.arange(len(points)), faces)
        if len(alone):
            raise ModelError(
                f"{what}: the node at {np.array2string(points[alone[0]], precision=6)} is not a corner of an "
                "outer face with all corners in the set, and a mortar is a mean over faces; give a set with "
                "all nodes of the interface, or tie by Collocated()"
            )
        others = outer_triangles(mesh, np.arange(mesh.n_nodes))
        own, other = _near(points[faces], mesh.nodes[others])
        coupling, area = _overlaps(points[faces[own]], mesh.nodes[others[other]], within)
        whole = _areas(points[faces])
        covered = np.bincount(own, area, minlength=len(faces))
        if (short := 1 - covered / whole).max() > _COVERED:
            worst = int(short.argmax())
            at = np.array2string(points[faces[worst]].mean(axis=0), precision=6)
            raise ModelError(
                f"{what}: {100 * short[worst]:.3g} % of the face about {at} has no match on the other part, "
                "which must cover the interface for a mortar; check the positions of the parts. `within` "
                "allows a larger distance; Collocated() does not need faces that cover the interface"
            )
        tributary = np.bincount(faces.ravel(), np.repeat(whole / 3, 3), minlength=len(points))
        rows, columns = np.broadcast_arrays(faces[own][:, :, None], others[other][:, None, :])
        matrix = sparse.coo_array(
            (coupling.ravel(), (rows.ravel(), columns.ravel())), (len(points), mesh.n_nodes)
        ).tocsr()
        matrix.data /= np.repeat(tributary, np.diff(matrix.indptr))
        return _padded(matrix)


def _areas(corners: FloatArray) -> FloatArray:
    """Areas of triangles (.., 3, 3)."""
    edges = corners[..., 1:, :] - corners[..., :1, :]
    return 0.5 * np.linalg.norm(np.cross(edges[..., 0, :], edges[..., 1, :]), axis=-1)


def _near(first: FloatArray, second: FloatArray) -> tuple[IntArray, IntArray]:
    """Row numbers of the pairs of triangles (T, 3, 3) and (U, 3, 3) that are near enough to overlap."""
    centres = first.mean(axis=1), second.mean(axis=1)
    reach = sum(
        float(np.linalg.norm(corners - centre[:, None], axis=2).max())
        for corners, centre in zip((first, second), centres, strict=True)
    )
    pairs = KDTree(centres[0]).sparse_distance_matrix(KDTree(centres[1]), reach, output_type="ndarray")
    return pairs["i"].astype(np.int64), pairs["j"].astype(np.int64)


def _overlaps(own: FloatArray, other: FloatArray, within: float) -> tuple[FloatArray, FloatArray]:
    """Int psi_i N_m dA (P, 3, 3) over the common part of pairs of triangles (P, 3, 3), and its area (P,).

    Area coordinates (1 - s - t, s, t) are those of the first triangle; the second triangle is projected onto
    the plane of the first.
    """
    edges = own[:, 1:] - own[:, :1]
    gram = edges @ edges.swapaxes(1, 2)
    offsets = other - own[:, :1]
    flat = np.asarray(np.linalg.solve(gram, edges @ offsets.swapaxes(1, 2)).swapaxes(1, 2), dtype=float)
    normal = np.cross(edges[:, 0], edges[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    height = np.einsum("pci,pi->pc", offsets, normal)
    to_other, upright = _area_map(flat)
    polygon = _common_polygon(flat, to_other, upright)
    middle = polygon.mean(axis=1, keepdims=True)
    fans = np.stack(
        [np.broadcast_to(middle, polygon.shape), polygon, np.roll(polygon, -1, axis=1)], axis=2
    )  # (P, v, 3, 2)
    spans = fans[:, :, 1:] - fans[:, :, :1]
    doubled = np.abs(spans[..., 0, 0] * spans[..., 1, 1] - spans[..., 0, 1] * spans[..., 1, 0])
    at = np.einsum("gc,pvci->pvgi", _MIDDLES, fans)
    N_own = np.concatenate([1 - at.sum(axis=-1, keepdims=True), at], axis=-1)
    N_other = _area_coordinates(at, to_other)
    # Faces that overlap in projection, but are farther than `within` apart, are on different sides of a body.
    close = np.abs(np.einsum("pvgm,pm->pvg", N_other, height)).max(axis=(1, 2)) <= within
    weight = doubled * (_areas(own) * close)[:, None] / 3  # 2 A times doubled / 2, over three points
    coupling = np.einsum("pv,pvgi,pvgm->pim", weight, 4 * N_own - 1, N_other, optimize=True)
    return coupling, 3 * weight.sum(axis=1)


def _area_map(flat: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Maps (P, 3, 3) of (1, s, t) to area coordinates of triangles (P, 3, 2); masks (P,) of nonzero areas."""
    corners = np.concatenate([np.ones((*flat.shape[:2], 1)), flat], axis=2).swapaxes(1, 2)
    upright = np.abs(np.linalg.det(corners)) > _INSIDE
    corners = np.where(upright[:, None, None], corners, np.eye(3))
    return np.linalg.inv(corners), upright


def _area_coordinates(at: FloatArray, to_other: FloatArray) -> FloatArray:
    """Area coordinates (P, .., 3) of points (P, .., 2)."""
    lifted = np.concatenate([np.ones((*at.shape[:-1], 1)), at], axis=-1)
    return np.einsum("pmi,p...i->p...m", to_other, lifted)


def _common_polygon(flat: FloatArray, to_other: FloatArray, upright: NDArray[np.bool_]) -> FloatArray:
    """Corners (P, 15, 2), in order, of the intersections of triangles (P, 3, 2) with the reference triangle.

    The corners are corners of one triangle inside the other, and intersections of sides. Unused rows repeat
    the first corner. For a pair without an intersection all corners are at one point.
    """
    reference = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    count = len(flat)
    ours = np.broadcast_to(reference, (count, 3, 2))
    ours_in = (_area_coordinates(ours, to_other) > -_INSIDE).all(axis=2)
    theirs_in = np.minimum(flat.min(axis=2), 1 - flat.sum(axis=2)) > -_INSIDE
    a, b = reference, np.roll(reference, -1, axis=0) - reference
    c, d = flat, np.roll(flat, -1, axis=1) - flat
    across = b[None, :, None, 0] * d[:, None, :, 1] - b[None, :, None, 1] * d[:, None, :, 0]  # (P, 3, 3)
    safe = np.where(np.abs(across) > _INSIDE, across, 1.0)
    gap = c[:, None] - a[None, :, None]
    along = (gap[..., 0] * d[:, None, :, 1] - gap[..., 1] * d[:, None, :, 0]) / safe
    beside = (gap[..., 0] * b[None, :, None, 1] - gap[..., 1] * b[None, :, None, 0]) / safe
    crossing = (np.abs(across) > _INSIDE) & (along >= 0) & (along <= 1) & (beside >= 0) & (beside <= 1)
    crosses = (a[None, :, None] + along[..., None] * b[None, :, None]).reshape(count, 9, 2)
    corners = np.concatenate([ours, flat, crosses], axis=1)
    there = np.concatenate([ours_in, theirs_in, crossing.reshape(count, 9)], axis=1) & upright[:, None]
    some = np.maximum(there.sum(axis=1), 1)
    middle = np.where(there[..., None], corners, 0.0).sum(axis=1) / some[:, None]
    spokes = corners - middle[:, None]
    angle = np.where(there, np.arctan2(spokes[..., 1], spokes[..., 0]), np.inf)
    order = np.argsort(angle, axis=1)
    corners = np.take_along_axis(corners, order[..., None], axis=1)
    there = np.take_along_axis(there, order, axis=1)
    first = np.where(there[:, :1, None], corners[:, :1], 0.0)
    return np.where(there[..., None], corners, first)


def _padded(matrix: sparse.csr_array) -> tuple[IntArray, FloatArray]:
    """Columns (n, c) and values of the rows of a matrix; short rows repeat their first column at weight 0."""
    counts = np.diff(matrix.indptr)
    place = np.arange(counts.max())
    inside = place < counts[:, None]
    number = matrix.indptr[:-1, None] + np.where(inside, place, 0)
    return matrix.indices[number].astype(np.int64), np.where(inside, matrix.data[number], 0.0)
