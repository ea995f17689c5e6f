"""Discrete Kirchhoff triangle (DKT): plate bending with a deflection and two rotations at three nodes.

The slopes beta of the normal (u = z beta_x, v = z beta_y) are quadratic over the triangle; Kirchhoff's beta
= -grad w holds at the corners and, along each side, at its middle, where w is cubic on the side and the
slope normal to the side is the mean of its ends. No deflection is needed inside.

Right-handed rotations: beta_x = ry, beta_y = -rx. Along a side of direction s the cubic deflection w makes
the slope at the middle mean(beta) - 3/2 s m, with the mismatch m = dw/l + s.mean(beta) of Kirchhoff's
condition.

Source: J.-L. Batoz, K.-J. Bathe, L.-W. Ho, "A study of three-node triangular plate bending elements",
Int. J. Numer. Methods Eng. 15 (1980) 1771-1812.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.fem.optimal_membrane import NEXT, linear_gradients

FloatArray = NDArray[np.float64]

# Middle of the sides 12, 23, 31 in area coordinates; with equal weights they integrate quadratics exactly.
MIDSIDES = 0.5 * np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]])
CENTRE = np.full((1, 3), 1 / 3)


def curvature(xy: FloatArray, points: FloatArray) -> FloatArray:
    """Curvatures beta_x,x  beta_y,y  beta_x,y + beta_y,x, linear over each triangle.

    Parameters
    ----------
    xy : float array (E, 3, 2)      corners, counter-clockwise
    points : float array (p, 3)     area coordinates
    Returns
    -------
    float array (E, p, 3, 12)       curvature xx, yy, xy (twice the twist) from rx ry of the three corners,
                                    then from a plane vector for each side (12, 23, 31), whose part along
                                    the side is its mismatch
    """
    gradients = _quadratic_gradients(xy, points)
    slopes = _slopes(xy)
    by_x = np.einsum("epm,emcn->epcn", gradients[..., 0], slopes)
    by_y = np.einsum("epm,emcn->epcn", gradients[..., 1], slopes)
    return np.stack([by_x[:, :, 0], by_y[:, :, 1], by_y[:, :, 0] + by_x[:, :, 1]], axis=2)


def side_directions(xy: FloatArray) -> FloatArray:
    """Unit vectors (E, 3, 2) along the sides 12, 23, 31."""
    side = xy[:, NEXT] - xy
    return side / np.linalg.norm(side, axis=2)[..., None]


def _quadratic_gradients(xy: FloatArray, points: FloatArray) -> FloatArray:
    """Gradients (E, p, 6, 2) of the quadratic shape functions: three corners, then mid-sides 12, 23, 31."""
    linear = linear_gradients(xy)[:, None]
    zeta = points[None, :, :, None]
    corners = (4 * zeta - 1) * linear
    midsides = 4 * (zeta * linear[:, :, NEXT] + zeta[:, :, NEXT] * linear)
    return np.concatenate([corners, midsides], axis=2)


def _slopes(xy: FloatArray) -> FloatArray:
    """Slopes beta (E, 6, 2, 12) at the six points of the quadratic interpolation; columns of `curvature`."""
    slopes = np.zeros((len(xy), 6, 2, 12))
    corner = np.arange(3)
    slopes[:, corner, 0, 2 * corner + 1] = 1
    slopes[:, corner, 1, 2 * corner] = -1
    slopes[:, 3:] = 0.5 * (slopes[:, :3] + slopes[:, NEXT])
    s = side_directions(xy)
    along = -1.5 * s[..., :, None] * s[..., None, :]
    for side in range(3):
        slopes[:, 3 + side, :, 6 + 2 * side : 8 + 2 * side] = along[:, side]
    return slopes
