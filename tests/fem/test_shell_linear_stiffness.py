"""The flat shell triangle at rest is the sum of two published elements, written out in their own freedoms."""

import numpy as np
import pytest

from supple.fem import HomogeneousSection, LaminateSection
from supple.fem.optimal_membrane import ALPHA, CORNER_BETA, higher_order_weight
from supple.fem.quadratic_strain import stiffness
from supple.fem.shell_kinematics import GREEN_LAGRANGE
from supple.fem.shell_triangle import element_axes, plane_coordinates, shell_triangle
from supple.mesh import CellType, box_beam

NEXT, LAST = [1, 2, 0], [2, 0, 1]


def optimal_membrane(xy):
    """Strain of the basic stiffness (3, 9) and strains H_m (3, 3, 9) of the higher-order one, on ux uy rz.

    Source: C. A. Felippa, Comput. Methods Appl. Mech. Engrg. 192 (2003) 2125-2168, (21) to (29).
    """
    (x1, y1), (x2, y2), (x3, y3) = xy
    area = 0.5 * ((x2 - x1) * (y3 - y1) - (x3 - x1) * (y2 - y1))
    L = np.zeros((9, 3))
    for a, (i, j) in enumerate(zip(NEXT, LAST, strict=True)):
        (xa, ya), (xi, yi), (xj, yj) = xy[a], xy[i], xy[j]
        L[3 * a] = yi - yj, 0, xj - xi
        L[3 * a + 1] = 0, xj - xi, yi - yj
        L[3 * a + 2] = (
            ALPHA / 6 * (yi - yj) * ((ya - yi) - (yj - ya)),
            ALPHA / 6 * (xj - xi) * ((xj - xa) - (xa - xi)),
            ALPHA / 3 * ((xa - xi) * (ya - yi) - (xj - xa) * (yj - ya)),
        )
    sides = np.array([xy[1] - xy[0], xy[2] - xy[1], xy[0] - xy[2]])
    length2 = (sides**2).sum(axis=1)
    natural = np.column_stack([sides**2, sides.prod(axis=1)]) / length2[:, None]
    opposite = np.array([xy[2] - xy[1], xy[0] - xy[2], xy[1] - xy[0]])
    deviation = np.zeros((3, 9))
    deviation[:, 0::3], deviation[:, 1::3] = opposite[:, 0] / (4 * area), opposite[:, 1] / (4 * area)
    deviation[:, 2::3] = np.eye(3)
    corner = [2 * area / 3 / length2[:, None] * np.roll(CORNER_BETA, (a, a), axis=(0, 1)) for a in range(3)]
    midside = [0.5 * (corner[a] + corner[NEXT[a]]) for a in range(3)]
    return L.T / (2 * area), np.linalg.inv(natural) @ np.array(midside) @ deviation, area


def kirchhoff_triangle(xy):
    """Curvatures (3, 3, 9) at the middles of the sides, on w rx ry.

    Source: J.-L. Batoz, K.-J. Bathe, L.-W. Ho, Int. J. Numer. Methods Eng. 15 (1980) 1771-1812, (11) to (20).
    """
    slopes = np.zeros((6, 2, 9))
    for a in range(3):
        slopes[a, 0, 3 * a + 2], slopes[a, 1, 3 * a + 1] = 1, -1
    for a in range(3):
        side = xy[NEXT[a]] - xy[a]
        length = np.linalg.norm(side)
        along, across = side / length, np.array([-side[1], side[0]]) / length
        ends = slopes[a], slopes[NEXT[a]]
        fall = np.zeros(9)
        fall[3 * NEXT[a]], fall[3 * a] = -1.5 / length, 1.5 / length
        slopes[3 + a] = np.outer(along, fall - 0.25 * along @ (ends[0] + ends[1]))
        slopes[3 + a] += np.outer(across, 0.5 * across @ (ends[0] + ends[1]))
    to_plane = np.linalg.inv(np.column_stack([xy, np.ones(3)]))[:2]
    curvatures = []
    for zeta in (np.array([0.5, 0.5, 0]), np.array([0, 0.5, 0.5]), np.array([0.5, 0, 0.5])):
        shape = [(4 * zeta[a] - 1) * to_plane[:, a] for a in range(3)]
        shape += [4 * (zeta[a] * to_plane[:, NEXT[a]] + zeta[NEXT[a]] * to_plane[:, a]) for a in range(3)]
        x, y = np.einsum("md,mcn->dcn", shape, slopes)
        curvatures.append([x[0], y[1], y[0] + x[1]])
    return np.array(curvatures)


def published_stiffness(xy, wall):
    basic, higher, area = optimal_membrane(xy)
    kappa = kirchhoff_triangle(xy)
    K = np.zeros((18, 18))
    plane = np.array([0, 1, 5, 6, 7, 11, 12, 13, 17])
    bending = np.array([2, 3, 4, 8, 9, 10, 14, 15, 16])
    K[np.ix_(plane, plane)] = area * basic.T @ wall.membrane @ basic
    weight = 0.75 * area * higher_order_weight(wall.membrane)
    K[np.ix_(plane, plane)] += weight * (higher.swapaxes(1, 2) @ wall.membrane @ higher).sum(axis=0)
    # The middle surface stands where the coupling is least; the nodes hold it by arms.
    height = (wall.coupling * wall.membrane).sum() / (wall.membrane**2).sum()
    coupling = wall.coupling - height * wall.membrane
    about_middle = wall.bending - 2 * height * wall.coupling + height**2 * wall.membrane
    by_coupling = coupling @ np.linalg.solve(wall.membrane, coupling)
    by_x, by_y = np.linalg.inv(np.column_stack([xy, np.ones(3)]))[:2]
    linear = np.zeros((3, 9))
    linear[0, 2::3], linear[1, 1::3], linear[2, 2::3], linear[2, 1::3] = by_x, -by_y, by_y, -by_x
    free = kappa.swapaxes(1, 2) @ (about_middle - by_coupling) @ kappa
    K[np.ix_(bending, bending)] = area / 3 * free.sum(axis=0) + area * linear.T @ by_coupling @ linear
    coupled = area * basic.T @ coupling @ linear
    K[np.ix_(plane, bending)] += coupled
    K[np.ix_(bending, plane)] += coupled.T
    arms = np.eye(18)
    for a in range(3):
        arms[6 * a, 6 * a + 4], arms[6 * a + 1, 6 * a + 3] = height, -height
    return arms.T @ K @ arms


@pytest.mark.parametrize("coupled", [False, True])
def test_the_linear_stiffness_is_that_of_the_two_elements(coupled, material, distorted):
    wall = HomogeneousSection(material, 0.03)
    if coupled:
        B = 0.3 * np.sqrt(wall.membrane * wall.bending)
        wall = LaminateSection(wall.membrane, B, wall.bending, 1.0, 1.0, (0.3, 1.0, 0.2))
    mesh = distorted(box_beam(1.0, 0.6, 0.4, 2, 1, 1), 0.06)
    corners = mesh.nodes[mesh.cells[CellType.TRIANGLE3]]
    axes = element_axes(corners, wall)
    dofs = np.zeros((len(corners), 18), dtype=int)
    found = stiffness(shell_triangle(corners, dofs, wall, GREEN_LAGRANGE))
    for K, xy, triad in zip(found, plane_coordinates(corners, axes), axes, strict=True):
        turn = np.kron(np.eye(6), triad)
        expected = turn.T @ published_stiffness(xy, wall) @ turn
        np.testing.assert_allclose(K, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
