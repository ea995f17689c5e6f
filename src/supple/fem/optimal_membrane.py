"""Optimal membrane triangle: three nodes with two displacements and a drilling rotation (ANDES, OPT).

The stiffness is the sum of a basic and a higher-order part. The basic part is that of the constant strain,
from the motion of the boundary; it alone passes the patch test. The higher-order part resists the deviation
of the drilling rotations from the mean rotation. Pure bending in the plane is exact for a rectangle of two
triangles of any aspect ratio.

In this file, drilling rotations are deviations d_i = rz_i - (v,x - u,y)/2 from the mean in-plane rotation of
the linear displacement.

Source: C. A. Felippa, "A study of optimal membrane triangles with drilling freedoms", Comput. Methods Appl.
Mech. Engrg. 192 (2003) 2125-2168, sections 3-5, with the OPT parameters.
"""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray

ALPHA = 1.5
"""Weight of the drilling rotations in the constant strain (alpha_b)."""

CORNER_BETA = np.array([[1.0, 2.0, 1.0], [0.0, 1.0, -1.0], [-1.0, -1.0, -2.0]])
"""Beta 1 to 9: natural strain on sides 21, 32, 13 (rows) at corner 1 from the three rotations (columns)."""

# Corner a is followed by NEXT[a] and LAST[a]: a, i, j in the formulas below.
NEXT, LAST = [1, 2, 0], [2, 0, 1]


def triangle_area(xy: FloatArray) -> FloatArray:
    """Areas (E,) of plane triangles (E, 3, 2), positive when counter-clockwise."""
    p, q = xy[:, 1] - xy[:, 0], xy[:, 2] - xy[:, 0]
    return 0.5 * (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])


def linear_gradients(xy: FloatArray) -> FloatArray:
    """Gradients (E, 3, 2) of the linear shape functions (area coordinates) of triangles (E, 3, 2)."""
    opposite = xy[:, LAST] - xy[:, NEXT]
    return np.stack([-opposite[..., 1], opposite[..., 0]], axis=-1) / (2 * triangle_area(xy))[:, None, None]


def drilling_strain(xy: FloatArray) -> FloatArray:
    """Constant strain that drilling rotations d_i add to the strain of the corner displacements.

    The sum of both strains is the strain L^T u / (A t) of the basic stiffness, with the lumping matrix L.

    xy : (E, 3, 2)    corners, counter-clockwise
    Returns (E, 3, 3): rows strains xx, yy, xy (engineering shear); columns d_1 d_2 d_3.
    """
    to_next, to_last = xy - xy[:, NEXT], xy[:, LAST] - xy
    (x_ai, y_ai), (x_ja, y_ja) = np.moveaxis(to_next, 2, 0), np.moveaxis(to_last, 2, 0)
    x_ji, y_ij = x_ja + x_ai, -(y_ja + y_ai)
    strain = [y_ij * (y_ai - y_ja), x_ji * (x_ja - x_ai), 2 * (x_ai * y_ai - x_ja * y_ja)]
    return ALPHA / 12 * np.stack(strain, axis=1) / triangle_area(xy)[:, None, None]


def drilling_stiffness(xy: FloatArray, membrane: FloatArray) -> FloatArray:
    """Higher-order stiffness (E, 3, 3) for drilling rotations d_i relative to the mean rotation.

        K_h = 3/4 beta_0 A sum_m H_m^T E H_m,   H_m the strain at the mid-sides from the deviations

    xy : (E, 3, 2)    corners, counter-clockwise
    membrane : (3, 3) or (E, 3, 3)    stiffness t E in the axes of xy
    """
    area = triangle_area(xy)
    sides = xy - xy[:, LAST]
    sides = sides[:, NEXT]  # 21, 32, 13
    squared_length = (sides**2).sum(axis=2)
    x, y = sides[..., 0], sides[..., 1]
    # Natural strain along a side: c^2 e_xx + s^2 e_yy + c s g_xy.
    natural = np.stack([x**2, y**2, x * y], axis=-1) / squared_length[..., None]
    to_cartesian = np.linalg.inv(natural)
    corner = np.stack([np.roll(CORNER_BETA, (a, a), axis=(0, 1)) for a in range(3)])
    midside = 0.5 * (corner + corner[NEXT])
    H = to_cartesian[:, None] @ (2 / 3 * (area[:, None] / squared_length)[:, None, :, None] * midside)
    E = membrane if membrane.ndim == 3 else membrane[None]
    weight = 0.75 * area * higher_order_weight(E)
    return weight[:, None, None] * (H.swapaxes(2, 3) @ (E[:, None] @ H)).sum(axis=1)


def higher_order_weight(E: FloatArray) -> FloatArray:
    """The factor beta_0 that makes pure bending exact, averaged over directions; at least 0.01.

    For an isotropic material it is (1 - 4 nu^2)/2.

    E : (..., 3, 3)    plane-stress stiffness times any factor, in any axes of the plane
    """
    E11, E12, E13, E22, E23, E33 = (E[..., i, j] for i, j in zip(*np.triu_indices(3), strict=True))
    W = (
        -6 * E12**3
        + 5 * E11**2 * E22
        - 5 * E12**2 * E22
        - E22 * (75 * E13**2 + 14 * E13 * E23 + 3 * E23**2)
        + 2 * E12 * (7 * E13**2 + 46 * E13 * E23 + 7 * E23**2)
        - E11 * (5 * E12**2 + 3 * E13**2 - 6 * E12 * E22 - 5 * E22**2 + 14 * E13 * E23 + 75 * E23**2)
        + E33 * (3 * E11**2 + 82 * E11 * E22 + 3 * E22**2)
        - 4 * E33 * (6 * E12**2 + 5 * E13**2 - 6 * E13 * E23 + 5 * E23**2)
        + 4 * E33**2 * (5 * E11 - 6 * E12 + 5 * E22)
    )
    weight = np.divide(256 * np.linalg.det(E), W, out=np.zeros_like(W), where=W != 0)
    return np.maximum(weight - 1.5, 0.01)
