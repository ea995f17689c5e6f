"""Materials: linear elasticity (St. Venant-Kirchhoff at finite strain), isotropic or not."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arguments import check_fields
from supple.errors import ModelError

__all__ = ["Anisotropic", "Isotropic"]


@dataclass(frozen=True)
class Isotropic:
    """An isotropic elastic material, in any consistent set of units.

    Parameters
    ----------
    youngs_modulus : float      E > 0, Pa
    poissons_ratio : float      nu in (-1, 1/2)
    density : float             rho >= 0, kg/m^3; 0 for statics alone
    stated_shear_modulus : float or None
            G, Pa, of an input deck that contains E, nu and G; None: G = E / (2 (1 + nu)). With another G, the
            stiffness of a solid or shell depends on the axes in which its strains are computed

    Raises
    ------
    ModelError   a constant that is not finite or outside its range
    """

    youngs_modulus: float
    poissons_ratio: float
    density: float
    stated_shear_modulus: float | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        for name, value in vars(self).items():
            if value is not None and not isfinite(value):
                raise ModelError(f"{name} is {value}; give a finite number")
        if self.youngs_modulus <= 0:
            raise ModelError(f"youngs_modulus is {self.youngs_modulus}; it must be positive (Pa in SI units)")
        if not -1 < self.poissons_ratio < 0.5:
            raise ModelError(
                f"poissons_ratio is {self.poissons_ratio}; it must lie in (-1, 0.5) "
                "(use 0.49 for a nearly incompressible material)"
            )
        if self.density < 0:
            raise ModelError(f"density is {self.density}; it must not be negative (kg/m^3 in SI units)")
        if self.stated_shear_modulus is not None and self.stated_shear_modulus <= 0:
            raise ModelError(f"stated_shear_modulus is {self.stated_shear_modulus}; it must be positive")

    @property
    def shear_modulus(self) -> float:
        """G, Pa: the stated shear modulus, or E / (2 (1 + nu)) if there is none."""
        if self.stated_shear_modulus is not None:
            return self.stated_shear_modulus
        return self.youngs_modulus / (2 * (1 + self.poissons_ratio))

    @property
    def plane_stress(self) -> NDArray[np.float64]:
        """Plane-stress stiffness (3, 3) for the strains xx, yy, xy (engineering shear)."""
        nu = self.poissons_ratio
        C = self.youngs_modulus / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
        if self.stated_shear_modulus is not None:
            C[2, 2] = self.stated_shear_modulus
        return C

    @property
    def elasticity(self) -> NDArray[np.float64]:
        """Stiffness (6, 6) for the strains xx, yy, zz, yz, xz, xy (engineering shears)."""
        nu = self.poissons_ratio
        twice = self.youngs_modulus / (1 + nu)
        C = np.diag([twice] * 3 + [self.shear_modulus] * 3)
        C[:3, :3] += twice * nu / (1 - 2 * nu)
        return C


@dataclass(frozen=True, eq=False)
class Anisotropic:
    """An elastic material given by its stiffness in material axes: `Section.directions`, or the mesh axes.

    Parameters
    ----------
    elasticity : float array (6, 6)     for the strains xx, yy, zz, yz, xz, xy (engineering shears), Pa
    density : float                     rho >= 0, kg/m^3; 0 for statics alone

    Raises
    ------
    ModelError   a stiffness of another shape, not finite, not symmetric or not positive definite; a density
                 that is negative or not finite
    """

    elasticity: NDArray[np.float64]
    density: float

    def __post_init__(self) -> None:
        C = stiffness_matrix("elasticity", self.elasticity, 6)
        object.__setattr__(self, "elasticity", C)
        lowest = lowest_scaled_eigenvalue(C)
        if lowest < 1e-12:
            raise ModelError(
                f"the elasticity is not positive definite (lowest eigenvalue {lowest:.3e} when scaled to a "
                "unit diagonal): such a material is unstable; check its constants"
            )
        check_not_negative(self, "{}", "density")


def stiffness_matrix(name: str, given: ArrayLike, n: int) -> NDArray[np.float64]:
    """A read-only copy of a symmetric matrix (n, n); ModelError, with `name`, for any other array."""
    matrix = np.array(given, dtype=np.float64)
    if matrix.shape != (n, n):
        raise ModelError(f"{name} has shape {matrix.shape}; expected ({n}, {n})")
    if not np.isfinite(matrix).all():
        raise ModelError(f"{name} has entries that are not finite; give numbers")
    asymmetry = np.abs(matrix - matrix.T).max()
    if asymmetry > 1e-9 * np.abs(matrix).max():
        raise ModelError(
            f"{name} is not symmetric (largest difference of mirrored entries {asymmetry:.3e}); correct it"
        )
    matrix.setflags(write=False)
    return matrix


def check_not_negative(record: object, label: str, *names: str) -> None:
    """Raise ModelError for a field that is negative or not finite; `label` is filled with its name."""
    for name in names:
        value = getattr(record, name)
        if not (isfinite(value) and value >= 0):
            raise ModelError(f"{label.format(name)} is {value}; it must be finite and not negative")


def lowest_scaled_eigenvalue(matrix: NDArray[np.float64]) -> float:
    """Lowest eigenvalue of a symmetric matrix scaled to a unit diagonal, so that units do not matter.

    Minus infinity where an entry of the diagonal is not positive.
    """
    diagonal = np.diag(matrix)
    if diagonal.min() <= 0:
        return -np.inf
    return float(np.linalg.eigvalsh(matrix / np.sqrt(np.outer(diagonal, diagonal)))[0])
