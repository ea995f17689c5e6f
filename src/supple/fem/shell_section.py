"""Shell sections: stiffness (A-B-D) and inertia per area of what stands through the thickness."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arguments import check_fields
from supple.errors import ModelError
from supple.fem.material import Isotropic

__all__ = ["HomogeneousSection", "LaminateSection", "ShellSection"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class HomogeneousSection:
    """A shell of one isotropic material.

        A = t C,  B = 0,  D = t^3/12 C,   C the plane-stress stiffness

    Parameters
    ----------
    material : Isotropic
    thickness : float       t > 0, m

    Raises
    ------
    ModelError   thickness not finite or not positive
    """

    material: Isotropic
    thickness: float

    def __post_init__(self) -> None:
        check_fields(self)
        if not (isfinite(self.thickness) and self.thickness > 0):
            raise ModelError(f"wall thickness is {self.thickness}; it must be a positive finite length")

    @property
    def membrane(self) -> FloatArray:
        """A (3, 3), N/m."""
        return self.thickness * self.material.plane_stress

    @property
    def coupling(self) -> FloatArray:
        """B (3, 3), N: none, as the section is symmetric about its middle."""
        return np.zeros((3, 3))

    @property
    def bending(self) -> FloatArray:
        """D (3, 3), N m."""
        return self.thickness**3 / 12 * self.material.plane_stress

    @property
    def mass_per_area(self) -> float:
        """Density times thickness, kg/m^2."""
        return self.material.density * self.thickness

    @property
    def rotary_inertia_per_area(self) -> float:
        """Density times t^3/12, kg."""
        return self.material.density * self.thickness**3 / 12

    @property
    def reference_direction(self) -> None:
        """None: an isotropic section is the same in every direction."""
        return None


@dataclass(frozen=True, eq=False)
class LaminateSection:
    """A laminate by its stiffness: forces N and moments M per length from strain and curvature.

        [N; M] = [A B; B D] [eps; kappa],   order xx, yy, xy (engineering shear, twice the twist)

    The section's x axis is `reference_direction` projected onto each element, its z axis the element normal.

    Parameters
    ----------
    membrane, coupling, bending : float array (3, 3)    A (N/m), B (N), D (N m), symmetric
    mass_per_area : float                               kg/m^2, positive
    rotary_inertia_per_area : float                     kg, the second moment of density through the thickness
    reference_direction : float array (3,)              direction of the laminate's x axis

    Raises
    ------
    ModelError   wrong shape, not finite, not symmetric, A-B-D not positive definite, mass not positive,
                 zero direction
    Source: R. M. Jones, Mechanics of Composite Materials, 2nd ed. (1999), eq. (4.22)-(4.24).
    """

    membrane: FloatArray
    coupling: FloatArray
    bending: FloatArray
    mass_per_area: float
    rotary_inertia_per_area: float
    reference_direction: ArrayLike = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("membrane", "coupling", "bending"):
            object.__setattr__(self, name, _stiffness(name, getattr(self, name)))
        ABD = np.block([[self.membrane, self.coupling], [self.coupling, self.bending]])
        # Scaled to unit diagonal, so that the test does not depend on the units of length.
        diagonal = np.diag(ABD)
        if diagonal.min() <= 0:
            raise ModelError(
                f"the A-B-D matrix has a diagonal entry {diagonal.min():.3e}; all must be positive"
            )
        lowest = np.linalg.eigvalsh(ABD / np.sqrt(np.outer(diagonal, diagonal)))[0]
        if lowest < 1e-12:
            raise ModelError(
                f"the A-B-D matrix is not positive definite (lowest eigenvalue {lowest:.3e} when scaled to a "
                "unit diagonal): check the units and the sign of the coupling B"
            )
        for name in ("mass_per_area", "rotary_inertia_per_area"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0):
                raise ModelError(f"{name} is {value}; it must be positive and finite")
        direction = np.array(self.reference_direction, dtype=np.float64)
        length = np.linalg.norm(direction)
        if direction.shape != (3,) or not (isfinite(length) and length > 0):
            raise ModelError(f"reference_direction is {self.reference_direction}; give three finite numbers")
        direction /= length
        direction.setflags(write=False)
        object.__setattr__(self, "reference_direction", direction)


ShellSection = HomogeneousSection | LaminateSection
"""What a shell is made of: its stiffnesses, and its mass and rotary inertia per area."""


def _stiffness(name: str, given: ArrayLike) -> FloatArray:
    matrix = np.array(given, dtype=np.float64)
    if matrix.shape != (3, 3):
        raise ModelError(f"laminate {name} stiffness has shape {matrix.shape}; expected (3, 3)")
    if not np.isfinite(matrix).all():
        raise ModelError(f"laminate {name} stiffness has entries that are not finite")
    asymmetry = np.abs(matrix - matrix.T).max()
    if asymmetry > 1e-9 * np.abs(matrix).max():
        raise ModelError(f"laminate {name} stiffness is not symmetric (difference {asymmetry:.3e})")
    matrix.setflags(write=False)
    return matrix
