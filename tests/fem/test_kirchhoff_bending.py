"""Discrete Kirchhoff triangle: constant curvature is exact, and plates converge at second order."""

import numpy as np
import pytest

from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.fem.kirchhoff_bending import CENTRE, MIDSIDES, curvature, side_directions
from supple.mesh import plate

RIGID = np.zeros((1, 3))
TRIANGLE = np.array([[[0.1, -0.2], [2.0, 0.3], [0.7, 1.4]]])


def test_constant_curvature_is_exact(rng):
    """w = x^T H x/2 + s.x + c with rx = w,y and ry = -w,x meets Kirchhoff's condition on all sides.

    Its curvature is -(w,xx  w,yy  2 w,xy) everywhere.
    """
    H = rng.normal(size=(2, 2))
    H = H + H.T
    slope = rng.normal(size=2)
    xy = TRIANGLE[0]
    gradient = xy @ H + slope
    q = np.concatenate([np.column_stack([gradient[:, 1], -gradient[:, 0]]).ravel(), np.zeros(6)])
    points = np.concatenate([MIDSIDES, CENTRE, np.eye(3)])
    expected = np.tile([-H[0, 0], -H[1, 1], -2 * H[0, 1]], (len(points), 1))
    np.testing.assert_allclose(curvature(TRIANGLE, points, RIGID)[0] @ q, expected, rtol=1e-11)


def test_only_the_mismatch_along_a_side_counts(rng):
    across = np.roll(side_directions(TRIANGLE)[0], 1, axis=1) * [-1, 1]
    q = np.concatenate([np.zeros(6), (rng.normal(size=(3, 1)) * across).ravel()])
    np.testing.assert_allclose(curvature(TRIANGLE, MIDSIDES, RIGID)[0] @ q, 0, atol=1e-14)


def test_curvature_is_linear_so_the_mean_of_the_midsides_is_the_centre():
    np.testing.assert_allclose(
        curvature(TRIANGLE, MIDSIDES, RIGID).mean(axis=1),
        curvature(TRIANGLE, CENTRE, RIGID)[:, 0],
        atol=1e-12,
    )


def supported_square(flexural_rigidity, pressure, side):
    """Centre of a simply supported square under uniform pressure: Navier's series (Timoshenko, art. 30)."""
    m = np.arange(1, 60, 2)
    sign = np.where(m % 4 == 1, 1.0, -1.0)
    terms = np.outer(sign / m, sign / m) / (m[:, None] ** 2 + m[None] ** 2) ** 2
    return 16 * pressure * side**4 / (np.pi**6 * flexural_rigidity) * terms.sum()


def clamped_square(flexural_rigidity, pressure, side):
    """Centre of a clamped square: 0.00126532 q a^4/D (Taylor and Govindjee 2004)."""
    return 0.00126532 * pressure * side**4 / flexural_rigidity


@pytest.mark.parametrize(
    ("exact", "edge_freedoms"), [(supported_square, [0, 1, 2, 5]), (clamped_square, [0, 1, 2, 3, 4, 5])]
)
def test_plate_deflection_converges_at_second_order(exact, edge_freedoms, held, solve_linear):
    wall = HomogeneousSection(Isotropic(1e7, 0.3, 1.0), 0.01)
    target = exact(wall.bending[0, 0], 2.0, 1.0)

    def error(n):
        mesh = plate(1.0, 1.0, n, n)
        model = shell_model(mesh, wall)
        every = np.arange(mesh.n_nodes)
        T = held(model, (mesh.nodes_of("boundary"), edge_freedoms), (every, [0, 1, 5]))
        load = np.zeros((mesh.n_nodes, 6))
        # Rows of the mass matrix sum to the area of a node.
        load[:, 2] = 2.0 * (model.mass @ np.tile([0, 0, 1.0, 0, 0, 0], mesh.n_nodes))[2::6]
        load /= wall.mass_per_area
        return solve_linear(model, T, load)[mesh.nodes_of("centre")[0], 2] / target - 1

    coarse, middle, fine = (abs(error(n)) for n in (8, 16, 32))
    assert fine < 5e-3
    assert np.log2(coarse / middle) > 1.7
    assert np.log2(middle / fine) > 1.8
