"""Walls of plies, against the closed forms of laminate theory."""

from __future__ import annotations

import numpy as np
import pytest

from supple.importers.laminate import laminate, moved_wall, orthotropic_ply

E, NU, T, RHO = 7e10, 0.3, 2e-3, 2700.0
G = E / (2 * (1 + NU))


def isotropic(thickness, angle=0.0):
    return orthotropic_ply(E, E, NU, G, G, G, density=RHO, thickness=thickness, angle=angle)


def test_one_isotropic_ply_is_a_plate():
    wall = laminate([isotropic(T)])
    C = E / (1 - NU**2) * np.array([[1, NU, 0], [NU, 1, 0], [0, 0, (1 - NU) / 2]])
    np.testing.assert_allclose(wall.membrane, T * C, rtol=1e-12)
    np.testing.assert_allclose(wall.bending, T**3 / 12 * C, rtol=1e-12)
    np.testing.assert_allclose(wall.shear, 5 / 6 * G * T * np.eye(2), rtol=1e-12)
    assert wall.mass_per_area == pytest.approx(RHO * T)
    assert wall.rotary_inertia_per_area == pytest.approx(RHO * T**3 / 12)


def test_cutting_a_ply_or_turning_an_isotropic_one_changes_nothing():
    whole, cut = laminate([isotropic(T)]), laminate([isotropic(0.3 * T, 0.4), isotropic(0.7 * T, -1.1)])
    for name in ("membrane", "bending", "shear"):
        np.testing.assert_allclose(getattr(cut, name), getattr(whole, name), rtol=1e-11, atol=1e-3)
    assert np.abs(cut.coupling).max() < 1e-9 * np.abs(whole.membrane).max() * T


def test_cross_ply_of_jones():
    """Two plies [0/90]: A16 = A26 = 0, B11 = -B22 = (Q22 - Q11) t^2 / 8 with the 0 ply below (Jones 4.59)."""
    plies = [
        orthotropic_ply(14e10, 1e10, 0.3, 5e9, 5e9, 3e9, density=1600, thickness=T / 2, angle=a)
        for a in (0, np.pi / 2)
    ]
    wall = laminate(plies)
    Q = plies[0].plane_stress
    assert wall.coupling[0, 0] == pytest.approx((Q[1, 1] - Q[0, 0]) * T**2 / 8)
    assert wall.coupling[1, 1] == pytest.approx(-wall.coupling[0, 0])
    assert wall.membrane[0, 0] == pytest.approx((Q[0, 0] + Q[1, 1]) * T / 2)


def test_shear_of_a_sandwich_is_that_of_its_core():
    """Thin stiff faces f on a soft core c: H = G (c + f)^2 / c to the first order [Allen 1969, eq. (2.8)]."""
    f, c, G_core = 1e-4, 0.02, 5e7
    face = isotropic(f)
    core = orthotropic_ply(1e3, 1e3, 0.3, 400.0, G_core, 2 * G_core, density=50, thickness=c)
    wall = laminate([face, core, face])
    assert wall.shear is not None
    expected = G_core * (c + f) ** 2 / c
    np.testing.assert_allclose(np.diag(wall.shear), [expected, 2 * expected], rtol=1e-4)


def test_a_wall_beside_its_nodes_is_the_same_wall():
    """By `bottom` or moved: the same; strain at its middle costs what it costs without the offset."""
    plies = [isotropic(T), orthotropic_ply(14e10, 1e10, 0.3, 5e9, 5e9, 3e9, density=1600, thickness=T)]
    centred, beside = laminate(plies), laminate(plies, bottom=0.01)
    moved = moved_wall(centred, 0.01 + T)
    np.testing.assert_allclose(moved.bending, beside.bending, rtol=1e-12)
    assert moved.mass_moment_per_area == pytest.approx(beside.mass_moment_per_area)
    kappa = np.array([1.0, 0.2, -0.4])
    strain = -(0.01 + T) * kappa  # at the nodes, so that the middle has none
    force = beside.membrane @ strain + beside.coupling @ kappa
    np.testing.assert_allclose(force, centred.coupling @ kappa, rtol=1e-9, atol=1e-6 * np.abs(force).max())
    np.testing.assert_allclose(beside.shear, centred.shear, rtol=1e-12)
    # The parallel-axis theorem for the mass.
    arm = 0.01 + T
    about_nodes = (
        centred.rotary_inertia_per_area
        + 2 * arm * centred.mass_moment_per_area
        + arm**2 * centred.mass_per_area
    )
    assert beside.rotary_inertia_per_area == pytest.approx(about_nodes)


def test_plies_rigid_in_shear():
    ply = orthotropic_ply(14e10, 1e10, 0.3, 5e9, 0.0, 0.0, density=1600, thickness=T)
    assert laminate([ply]).shear is None
    assert laminate([ply, isotropic(T)]).shear is not None


def test_added_mass_has_no_stiffness():
    bare, loaded = laminate([isotropic(T)]), laminate([isotropic(T)], added_mass=3.0)
    np.testing.assert_array_equal(bare.membrane, loaded.membrane)
    assert loaded.mass_per_area == pytest.approx(bare.mass_per_area + 3.0)


def test_a_ply_without_density_is_marked_unless_the_wall_has_added_mass():
    core = orthotropic_ply(E, E, NU, G, G, G, density=0.0, thickness=T)
    assert laminate([isotropic(T), core], bottom=0.0).lacks_density
    assert not laminate([isotropic(T), core], added_mass=1.0).lacks_density
    assert not laminate([isotropic(T), isotropic(T)]).lacks_density
