"""Discrete Kirchhoff triangle (DKT): plate bending; deflection and two rotations at each of three nodes.

The slopes beta of the normal (u = z beta_x, v = z beta_y) are quadratic over the triangle. Kirchhoff's
condition, beta = -grad w, holds at the corners and, for the component along a side, at its middle. On a side
w is cubic, and the slope normal to the side at its middle is the mean of the slopes at its ends. The
deflection inside the triangle is not interpolated.

Right-handed rotations: beta_x = ry, beta_y = -rx. On a side of length l and direction s, dw is the difference
of the deflections at its ends. With linear slopes, Kirchhoff's condition along the side is violated by the
mismatch m = dw/l + s.mean(beta); with the cubic deflection, the slopes at the middle are
mean(beta) - 3/2 s m.

With transverse shear (discrete Kirchhoff-Mindlin triangle, DKMT) the mismatch of a side is divided as in a
Timoshenko beam along the side: m / (1 + phi) is bending, m phi / (1 + phi) is shear. Here phi = 12 D / (H
l^2), with the bending stiffness D and the transverse shear stiffness H in that direction. For phi = 0 (rigid
in shear) the element is the DKT, so thin walls do not lock.

Sources: J.-L. Batoz, K.-J. Bathe, L.-W. Ho, "A study of three-node triangular plate bending elements",
Int. J. Numer. Methods Eng. 15 (1980) 1771-1812; I. Katili, "A new discrete Kirchhoff-Mindlin element based on
Mindlin-Reissner plate theory and assumed shear strain fields, part I: an extended DKT element for thick-plate
bending analysis", Int. J. Numer. Methods Eng. 36 (1993) 1859-1883.
"""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray
from supple.fem.optimal_membrane import NEXT, linear_gradients

# Middle of the sides 12, 23, 31 in area coordinates; with equal weights they integrate quadratics exactly.
MIDSIDES = 0.5 * np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]])
CENTRE = np.full((1, 3), 1 / 3)

# Sides that meet at each corner.
AT_CORNER = [0, 1, 2], [2, 0, 1]


def curvature(xy: FloatArray, points: FloatArray, phi: FloatArray) -> FloatArray:
    """Curvatures beta_x,x  beta_y,y  beta_x,y + beta_y,x, linear over each triangle.

    xy : (E, 3, 2)    corners, counter-clockwise
    points : (p, 3)    area coordinates
    phi : (E, 3)    shear flexibility of the sides, zero where shear is rigid
    Returns (E, p, 3, 12): rows: curvatures xx, yy, xy (twice the twist); columns: rx ry of the three corners,
    then x y of an in-plane vector for each side (12, 23, 31), whose component along the side is the mismatch.
    """
    gradients = _quadratic_gradients(xy, points)
    slopes = _slopes(xy, phi)
    by_x = np.einsum("epm,emcn->epcn", gradients[..., 0], slopes)
    by_y = np.einsum("epm,emcn->epcn", gradients[..., 1], slopes)
    return np.stack([by_x[:, :, 0], by_y[:, :, 1], by_y[:, :, 0] + by_x[:, :, 1]], axis=2)


def linear_curvature(xy: FloatArray) -> FloatArray:
    """Curvature (E, 3, 12) of slopes that are linear between the corners; columns as of `curvature`."""
    by_x, by_y = np.moveaxis(linear_gradients(xy), 2, 0)
    found = np.zeros((len(xy), 3, 12))
    rx, ry = slice(0, 6, 2), slice(1, 6, 2)
    found[:, 0, ry], found[:, 1, rx] = by_x, -by_y
    found[:, 2, ry], found[:, 2, rx] = by_y, -by_x
    return found


def side_shear_flexibility(xy: FloatArray, bending: FloatArray, shear: FloatArray | None) -> FloatArray:
    """Ratios phi (E, 3) = 12 D_s / (H_s l^2) of sides 12, 23, 31; D_s, H_s: stiffnesses along the side.

    bending : (3, 3) at zero membrane forces, N m;  shear : (2, 2), N/m; None: rigid in shear
    """
    if shear is None:
        return np.zeros((len(xy), 3))
    side = xy[:, NEXT] - xy
    squared_length = (side**2).sum(axis=2)
    s = side_directions(xy)
    bent = np.stack([s[..., 0] ** 2, s[..., 1] ** 2, 2 * s[..., 0] * s[..., 1]], axis=-1)
    D = np.einsum("eki,ij,ekj->ek", bent, bending, bent)
    return 12 * D / (np.einsum("eki,ij,ekj->ek", s, shear, s) * squared_length)


def transverse_shear(xy: FloatArray, points: FloatArray, phi: FloatArray) -> FloatArray:
    """Transverse shear strains xz, yz (E, p, 2, 12), linear over each triangle; columns as of `curvature`.

    The component along a side is phi / (1 + phi) times the mismatch; both sides at a corner define the strain
    there.
    """
    s = side_directions(xy)
    share = (phi / (1 + phi))[..., None] * s
    at_corners = np.zeros((len(xy), 3, 2, 12))
    for corner, (one, other) in enumerate(zip(*AT_CORNER, strict=True)):
        from_sides = np.linalg.inv(s[:, [one, other]])
        for place, side in enumerate((one, other)):
            columns = slice(6 + 2 * side, 8 + 2 * side)
            at_corners[:, corner, :, columns] = from_sides[:, :, place, None] * share[:, side, None]
    return np.einsum("pc,ecin->epin", points, at_corners)


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


def _slopes(xy: FloatArray, phi: FloatArray) -> FloatArray:
    """Slopes beta (E, 6, 2, 12) at the six points of the quadratic interpolation; columns of `curvature`."""
    slopes = np.zeros((len(xy), 6, 2, 12))
    corner = np.arange(3)
    slopes[:, corner, 0, 2 * corner + 1] = 1
    slopes[:, corner, 1, 2 * corner] = -1
    slopes[:, 3:] = 0.5 * (slopes[:, :3] + slopes[:, NEXT])
    s = side_directions(xy)
    along = (-1.5 / (1 + phi))[..., None, None] * s[..., :, None] * s[..., None, :]
    for side in range(3):
        slopes[:, 3 + side, :, 6 + 2 * side : 8 + 2 * side] = along[:, side]
    return slopes
