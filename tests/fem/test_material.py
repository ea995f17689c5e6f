import numpy as np
import pytest

from supple.errors import ModelError
from supple.fem import Anisotropic, Isotropic


def test_uniaxial_stress_gives_youngs_modulus_and_poissons_ratio():
    """The compliance is Hooke's: eps = sigma/E along, -nu sigma/E across."""
    material = Isotropic(70e9, 0.33, 2700.0)
    for stiffness, n in ((material.elasticity, 3), (material.plane_stress, 2)):
        strain = np.linalg.solve(stiffness, np.eye(len(stiffness))[0])
        expected = np.zeros(len(stiffness))
        expected[:n] = [1, -0.33, -0.33][:n]
        np.testing.assert_allclose(strain, expected / 70e9, rtol=1e-12, atol=1e-25)


def test_shear_modulus():
    material = Isotropic(2.0, 0.25, 1.0)
    assert material.shear_modulus == pytest.approx(0.8)
    assert material.elasticity[5, 5] == pytest.approx(0.8)
    assert material.plane_stress[2, 2] == pytest.approx(0.8)


def test_a_stated_shear_modulus_takes_the_place_of_the_isotropic_one():
    material = Isotropic(2.0, 0.25, 0.0, stated_shear_modulus=0.5)
    as_ever = Isotropic(2.0, 0.25, 0.0)
    for stiffness, before in (
        (material.elasticity, as_ever.elasticity),
        (material.plane_stress, as_ever.plane_stress),
    ):
        assert stiffness[-1, -1] == 0.5
        np.testing.assert_allclose(stiffness[:2, :2], before[:2, :2], rtol=1e-15)


@pytest.mark.parametrize(
    ("elasticity", "density", "message"),
    [
        (np.eye(5), 1.0, r"elasticity has shape \(5, 5\); expected \(6, 6\)"),
        (np.full((6, 6), np.nan), 1.0, "elasticity has entries that are not finite"),
        (np.triu(np.ones((6, 6))), 1.0, "elasticity is not symmetric"),
        (np.ones((6, 6)), 1.0, "elasticity is not positive definite"),
        (-np.eye(6), 1.0, "elasticity is not positive definite"),
        (np.eye(6), -1.0, "density is -1.0"),
    ],
)
def test_impossible_elasticities_are_refused(elasticity, density, message):
    with pytest.raises(ModelError, match=message):
        Anisotropic(elasticity, density)


@pytest.mark.parametrize(
    ("constants", "message"),
    [
        ((np.nan, 0.3, 1.0), "youngs_modulus is nan"),
        ((1.0, np.inf, 1.0), "poissons_ratio is inf"),
        ((0.0, 0.3, 1.0), "youngs_modulus is 0.0; it must be positive"),
        ((1.0, 0.5, 1.0), r"poissons_ratio is 0.5; it must lie in \(-1, 0.5\)"),
        ((1.0, -1.0, 1.0), r"poissons_ratio is -1.0; it must lie in \(-1, 0.5\)"),
        ((1.0, 0.3, -1.0), "density is -1.0; it must not be negative"),
        ((1.0, 0.3, 1.0, 0.0), "stated_shear_modulus is 0.0; it must be positive"),
    ],
)
def test_impossible_constants_are_refused(constants, message):
    with pytest.raises(ModelError, match=message):
        Isotropic(*constants)
