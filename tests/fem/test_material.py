import numpy as np
import pytest

from supple.errors import ModelError
from supple.fem import Isotropic


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


@pytest.mark.parametrize(
    ("constants", "message"),
    [
        ((np.nan, 0.3, 1.0), "youngs_modulus is nan"),
        ((1.0, np.inf, 1.0), "poissons_ratio is inf"),
        ((0.0, 0.3, 1.0), "youngs_modulus is 0.0; it must be positive"),
        ((1.0, 0.5, 1.0), r"poissons_ratio is 0.5; it must lie in \(-1, 0.5\)"),
        ((1.0, -1.0, 1.0), r"poissons_ratio is -1.0; it must lie in \(-1, 0.5\)"),
        ((1.0, 0.3, 0.0), "density is 0.0; it must be positive"),
    ],
)
def test_impossible_constants_are_refused(constants, message):
    with pytest.raises(ModelError, match=message):
        Isotropic(*constants)
