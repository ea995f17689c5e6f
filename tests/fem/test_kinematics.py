"""Kinematics: the quadratic forms are those of the Green-Lagrange strain of continuum mechanics."""

import numpy as np

from supple.fem.kinematics import SOLID_FORM
from supple.fem.shell_kinematics import GREEN_LAGRANGE, MEMBRANE, VON_KARMAN


def engineering(E):
    return np.array([E[0, 0], E[1, 1], E[2, 2], 2 * E[1, 2], 2 * E[0, 2], 2 * E[0, 1]])


def test_solid_form_is_the_quadratic_part_of_green_lagrange(rng):
    """E = (F^T F - 1)/2 with F = 1 + H has the quadratic part H^T H/2."""
    H = rng.normal(size=(3, 3))
    a = H.ravel()
    np.testing.assert_allclose(0.5 * a @ SOLID_FORM @ a, engineering(0.5 * H.T @ H), rtol=1e-14)


def test_membrane_form_is_green_lagrange_in_the_plane(rng):
    H = rng.normal(size=(3, 2))
    a = H.ravel()
    E = 0.5 * H.T @ H
    form = GREEN_LAGRANGE.form[MEMBRANE, :6, :6]
    np.testing.assert_allclose(0.5 * a @ form @ a, [E[0, 0], E[1, 1], 2 * E[0, 1]], rtol=1e-14)


def test_von_karman_keeps_the_slopes_of_the_normal_displacement(rng):
    """1/2 (w,x^2, w,y^2, 2 w,x w,y)."""
    gradients = rng.normal(size=6)
    a = gradients[list(VON_KARMAN.gradients)]
    x, y = gradients[4:]
    strains = 0.5 * a @ VON_KARMAN.form @ a
    np.testing.assert_allclose(strains[MEMBRANE], [x * x / 2, y * y / 2, x * y], rtol=1e-14)
    np.testing.assert_array_equal(strains[MEMBRANE.stop :], 0)
