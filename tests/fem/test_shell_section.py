import numpy as np
import pytest

from supple.errors import ModelError
from supple.fem import HomogeneousSection, LaminateSection

A, B, D = np.diag([4.0, 3.0, 1.0]), np.diag([0.5, -0.5, 0.0]), np.diag([1.0, 1.0, 0.4])


def laminate(**changes):
    arguments = {
        "membrane": A,
        "coupling": B,
        "bending": D,
        "mass_per_area": 1.0,
        "rotary_inertia_per_area": 0.01,
    }
    return LaminateSection(**(arguments | changes))


def test_homogeneous_wall_is_the_integral_through_the_thickness(material):
    """A, B, D = integral of (1, z, z^2) C, and the inertia that of (1, z^2) rho."""
    wall = HomogeneousSection(material, 0.2)
    z, w = np.polynomial.legendre.leggauss(3)
    z, w = 0.1 * z, 0.1 * w
    C = material.plane_stress
    np.testing.assert_allclose(wall.membrane, w.sum() * C, rtol=1e-14)
    np.testing.assert_allclose(wall.coupling, (w @ z) * C, atol=1e-5)
    np.testing.assert_allclose(wall.bending, (w @ z**2) * C, rtol=1e-14)
    assert wall.mass_per_area == pytest.approx(w.sum() * material.density)
    assert wall.rotary_inertia_per_area == pytest.approx((w @ z**2) * material.density)


def test_an_offset_wall_is_the_integral_about_the_nodes(material):
    wall = HomogeneousSection(material, 0.2, offset=0.3, added_mass=7.0)
    z, w = np.polynomial.legendre.leggauss(3)
    z, w = 0.3 + 0.1 * z, 0.1 * w
    C = material.plane_stress
    np.testing.assert_allclose(wall.coupling, (w @ z) * C, rtol=1e-14)
    np.testing.assert_allclose(wall.bending, (w @ z**2) * C, rtol=1e-14)
    assert wall.mass_per_area == pytest.approx(w.sum() * material.density + 7.0)
    assert wall.rotary_inertia_per_area == pytest.approx((w @ z**2) * material.density + 7.0 * 0.3**2)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"offset": np.nan}, "offset of a wall is nan"),
        ({"added_mass": -1.0}, "added_mass of a wall is -1.0"),
        ({"shear_factor": -1.0}, "shear_factor of a wall is -1.0"),
    ],
)
def test_impossible_walls_are_refused(material, changes, message):
    with pytest.raises(ModelError, match=message):
        HomogeneousSection(material, 0.2, **changes)


@pytest.mark.parametrize("thickness", [0.0, -1.0, np.nan, np.inf])
def test_impossible_thickness_is_refused(material, thickness):
    with pytest.raises(ModelError, match="wall thickness is"):
        HomogeneousSection(material, thickness)


def test_laminate_keeps_its_own_read_only_copy():
    given = A.copy()
    wall = laminate(membrane=given)
    given[0, 0] = -1
    assert wall.membrane[0, 0] == 4
    assert not wall.membrane.flags.writeable


def test_positive_definiteness_does_not_depend_on_units():
    """The same laminate in millimetres: A, B, D scale by 1e-3, 1, 1e3."""
    laminate(membrane=A * 1e-3, coupling=B, bending=D * 1e3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"membrane": np.eye(2)}, r"membrane stiffness has shape \(2, 2\)"),
        ({"bending": D * np.nan}, "bending stiffness has entries that are not finite"),
        ({"coupling": np.triu(np.ones((3, 3)))}, "coupling stiffness is not symmetric"),
        ({"membrane": -A}, "diagonal entry -4"),
        ({"coupling": 5 * B}, "A-B-D matrix is not positive definite"),
        ({"bending": 0 * D}, "A-B-D matrix is not positive definite"),
        ({"membrane": 0 * A, "coupling": 0 * B, "bending": 0 * D}, "A-B-D matrix is not positive definite"),
        ({"mass_per_area": -1.0}, "mass_per_area is -1.0"),
        ({"shear": -np.eye(2)}, "shear stiffness is not positive definite"),
        ({"thickness": 0.0}, "laminate thickness is 0.0"),
        ({"mass_offset": np.inf}, "mass_offset is inf"),
        ({"rotary_inertia_per_area": np.nan}, "rotary_inertia_per_area is nan"),
        ({"reference_direction": (0.0, 0.0, 0.0)}, "reference_direction is"),
    ],
)
def test_impossible_laminates_are_refused(changes, message):
    with pytest.raises(ModelError, match=message):
        laminate(**changes)
