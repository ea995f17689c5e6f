"""Materials: isotropic linear elasticity (St. Venant-Kirchhoff at finite strain)."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_fields
from supple.errors import ModelError

__all__ = ["Isotropic"]


@dataclass(frozen=True)
class Isotropic:
    """An isotropic elastic material, in any consistent set of units.

    Parameters
    ----------
    youngs_modulus : float      E > 0, Pa
    poissons_ratio : float      nu in (-1, 1/2)
    density : float             rho > 0, kg/m^3

    Raises
    ------
    ModelError   a constant that is not finite or outside its range
    """

    youngs_modulus: float
    poissons_ratio: float
    density: float

    def __post_init__(self) -> None:
        check_fields(self)
        for name, value in vars(self).items():
            if not isfinite(value):
                raise ModelError(f"{name} is {value}; give a finite number")
        if self.youngs_modulus <= 0:
            raise ModelError(f"youngs_modulus is {self.youngs_modulus}; it must be positive (Pa in SI units)")
        if not -1 < self.poissons_ratio < 0.5:
            raise ModelError(
                f"poissons_ratio is {self.poissons_ratio}; it must lie in (-1, 0.5) "
                "(use 0.49 for a nearly incompressible material)"
            )
        if self.density <= 0:
            raise ModelError(f"density is {self.density}; it must be positive (kg/m^3 in SI units)")

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu))."""
        return self.youngs_modulus / (2 * (1 + self.poissons_ratio))

    @property
    def plane_stress(self) -> NDArray[np.float64]:
        """Plane-stress stiffness (3, 3) for the strains xx, yy, xy (engineering shear)."""
        nu = self.poissons_ratio
        C = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
        return self.youngs_modulus / (1 - nu**2) * C

    @property
    def elasticity(self) -> NDArray[np.float64]:
        """Stiffness (6, 6) for the strains xx, yy, zz, yz, xz, xy (engineering shears)."""
        G, nu = self.shear_modulus, self.poissons_ratio
        C = np.diag([2 * G] * 3 + [G] * 3)
        C[:3, :3] += 2 * G * nu / (1 - 2 * nu)
        return C
