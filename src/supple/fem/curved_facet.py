"""A flat triangle that represents a curved surface: in-plane effects of the bending of the surface.

A smooth surface that bends without stretching shortens the chords between its points and rotates them in the
planes of the facets. Facets that treat these effects as strain lock where the angle between neighbours, times
their size, exceeds the thickness. The curvature K of the surface and its change W are constant. The heights
`z = 1/2 x^T K x + linear` and `w = 1/2 x^T W x + linear` are zero at the corners. At corner i the slope of z
is g_i, that of w is b_i. Without membrane strain, `u_(a,b) + 1/2 (z,a w,b + z,b w,a) = 0`. Its integral is

    along side k, from corner i to j    e_k = -1/12 (s_k.(g_j - g_i)) (s_k.(b_j - b_i))
    drilling of corner i                d_i = 1/2 g_i x b_i - 1/6 g_i x (b_j + b_k) + 1/6 (g_j + g_k) x b_i

exactly. e_k and d_i are subtracted from the strain and drilling of the facet. b_i is computed from the
strains of the facet, which rigid motions do not change.

The strain e_k is that of a shallow shell, averaged over the side (K. Marguerre, Proc. 5th Int. Congr. Appl.
Mech. (1938) 93-101).
"""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray
from supple.fem.kirchhoff_bending import side_directions
from supple.fem.optimal_membrane import LAST, NEXT, linear_gradients


def bent_with_surface(xy: FloatArray, curvature: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Membrane strain and drilling due to inextensional bending in facets, (E, 3, 12) each.

    xy : (E, 3, 2)    corners, counter-clockwise, m
    curvature : (E, 2, 2)    K of the surface, in the plane of each facet, 1/m
    Returns strain rows xx yy xy (engineering shear), drilling rows by corner; columns as in
    `kirchhoff_bending.curvature`.
    """
    s = side_directions(xy)
    g, b = _surface_slopes(xy, curvature)[..., None], _bend_slopes(xy)
    along_g, along_b = (np.einsum("eki,ekin->ekn", s, each[:, NEXT] - each) for each in (g, b))
    natural = np.stack([s[..., 0] ** 2, s[..., 1] ** 2, s[..., 0] * s[..., 1]], axis=-1)
    others_g, others_b = (each[:, NEXT] + each[:, LAST] for each in (g, b))
    drilling = _cross(g, b) / 2 - _cross(g, others_b) / 6 + _cross(others_g, b) / 6
    return np.linalg.solve(natural, -along_g * along_b / 12), drilling


def _surface_slopes(xy: FloatArray, curvature: FloatArray) -> FloatArray:
    """Slopes g (E, 3, 2) at the corners of heights of constant curvature that vanish there."""
    heights = 0.5 * np.einsum("eai,eij,eaj->ea", xy, curvature, xy)
    linear = np.einsum("ea,eai->ei", heights, linear_gradients(xy))
    return xy @ curvature - linear[:, None]


def _bend_slopes(xy: FloatArray) -> FloatArray:
    """Slopes b (E, 3, 2, 12) at the corners, from the differences of the corner rotations.

    The mean slope is that of constant curvature, `s_k.(b_i + b_j) = 0`, on all three sides by least squares.
    """
    b = np.zeros((len(xy), 3, 2, 12))
    corner = np.arange(3)
    b[:, corner, 0, 2 * corner + 1] = -1
    b[:, corner, 1, 2 * corner] = 1
    b -= b.mean(axis=1, keepdims=True)
    s = side_directions(xy)
    on_chords = np.einsum("eki,ekin->ekn", s, 0.5 * (b + b[:, NEXT]))
    s_t = s.swapaxes(1, 2)
    return b - np.linalg.solve(s_t @ s, s_t @ on_chords)[:, None]


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Normal component (E, 3, n) of the cross products of plane vectors (E, 3, 2, n or 1)."""
    return a[:, :, 0] * b[:, :, 1] - a[:, :, 1] * b[:, :, 0]
