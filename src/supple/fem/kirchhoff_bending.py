"""Discrete Kirchhoff triangle (DKT): plate bending with a deflection and two rotations at three nodes.

The slopes beta of the normal (u = z beta_x, v = z beta_y) are quadratic over the triangle; Kirchhoff's beta
= -grad w holds at the corners and, along each side, at its middle, where w is cubic on the side and the
slope normal to the side is the mean of its ends. No deflection is needed inside.

Freedoms in this file: w, rx, ry of each node (right-handed rotations: beta_x = ry, beta_y = -rx).

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
    float array (E, p, 3, 9)        curvature xx, yy, xy (twice the twist) from w rx ry, node by node
    """
    gradients = _quadratic_gradients(xy, points)
    slopes = _slopes(xy)
    by_x = np.einsum("epm,emcn->epcn", gradients[..., 0], slopes)
    by_y = np.einsum("epm,emcn->epcn", gradients[..., 1], slopes)
    return np.stack([by_x[:, :, 0], by_y[:, :, 1], by_y[:, :, 0] + by_x[:, :, 1]], axis=2)


def _quadratic_gradients(xy: FloatArray, points: FloatArray) -> FloatArray:
    """Gradients (E, p, 6, 2) of the quadratic shape functions: three corners, then mid-sides 12, 23, 31."""
    linear = linear_gradients(xy)[:, None]
    zeta = points[None, :, :, None]
    corners = (4 * zeta - 1) * linear
    midsides = 4 * (zeta * linear[:, :, NEXT] + zeta[:, :, NEXT] * linear)
    return np.concatenate([corners, midsides], axis=2)


def _slopes(xy: FloatArray) -> FloatArray:
    """Slopes beta at the six points of the quadratic interpolation from the nine freedoms, (E, 6, 2, 9)."""
    corner = np.zeros((3, 2, 3, 3))
    corner[[0, 1, 2], 0, [0, 1, 2], 2] = 1
    corner[[0, 1, 2], 1, [0, 1, 2], 1] = -1
    deflection = np.zeros((3, 3, 3))
    deflection[[0, 1, 2], [0, 1, 2], 0] = 1
    corner, deflection = corner.reshape(3, 2, 9), deflection.reshape(3, 9)

    side = xy[:, NEXT] - xy
    length = np.linalg.norm(side, axis=2)
    s = side / length[..., None]
    mean = 0.5 * (corner + corner[NEXT])
    # Cubic w on the side, of slope -beta_s at its ends: beta_s = -3/2 dw/l - 1/2 mean(beta_s) at the middle.
    drop = (deflection - deflection[NEXT]) / length[..., None]
    correction = 1.5 * (drop - np.einsum("ema,man->emn", s, mean))
    midside = mean + s[..., None] * correction[:, :, None]
    return np.concatenate([np.broadcast_to(corner, (len(xy), 3, 2, 9)), midside], axis=1)
