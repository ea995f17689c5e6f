"""Shell sections: stiffness (A-B-D) and inertia of a wall per area, integrated over its thickness."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem.material import Isotropic, check_not_negative, lowest_scaled_eigenvalue, stiffness_matrix

__all__ = ["HomogeneousSection", "LaminateSection", "ShellSection"]


@dataclass(frozen=True)
class HomogeneousSection:
    """A shell of one isotropic material.

        A = t C,  B = z A,  D = t^3/12 C + z^2 A

    A, B, D are the membrane, coupling and bending stiffness about the surface of the nodes; C is the
    plane-stress stiffness of the material.

    Parameters
    ----------
    thickness : float       t > 0, m
    offset : float          z, distance of the mid-surface from the nodes, along the normal, m
    added_mass : float      non-structural mass at the mid-surface, kg/m^2
    shear_factor : float    k in the transverse shear stiffness k G t, 5/6 for a solid wall; 0: rigid in shear

    Raises
    ------
    ModelError   a thickness that is not positive and finite; an added mass or shear factor that is negative
                 or not finite; an offset that is not finite
    """

    material: Isotropic
    thickness: float
    offset: float = 0.0
    added_mass: float = 0.0
    shear_factor: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self)
        if not (isfinite(self.thickness) and self.thickness > 0):
            raise ModelError(f"wall thickness is {self.thickness}; it must be a positive finite length")
        if not isfinite(self.offset):
            raise ModelError(f"the offset of a wall is {self.offset}; give a finite length")
        check_not_negative(self, "{} of a wall", "added_mass", "shear_factor")

    @property
    def membrane(self) -> FloatArray:
        """A (3, 3), N/m."""
        return self.thickness * self.material.plane_stress

    @property
    def coupling(self) -> FloatArray:
        """B (3, 3), N: zero if the nodes are on the mid-surface."""
        return self.offset * self.membrane

    @property
    def bending(self) -> FloatArray:
        """D (3, 3), N m."""
        return (self.thickness**3 / 12 + self.offset**2 * self.thickness) * self.material.plane_stress

    @property
    def shear(self) -> FloatArray | None:
        """Transverse shear stiffness (2, 2), order xz, yz, N/m; None for a section rigid in shear."""
        if self.shear_factor == 0.0:
            return None
        return self.shear_factor * self.material.shear_modulus * self.thickness * np.eye(2)

    @property
    def mass_per_area(self) -> float:
        """Density times thickness and the added mass, kg/m^2."""
        return self.material.density * self.thickness + self.added_mass

    @property
    def mass_offset(self) -> float:
        """Distance of the mass centre from the nodes, along the normal, m."""
        return self.offset

    @property
    def rotary_inertia_per_area(self) -> float:
        """Density times t^3/12, plus mass per area times offset squared: inertia about the nodes, kg."""
        return self.material.density * self.thickness**3 / 12 + self.mass_per_area * self.offset**2

    reference_direction: ClassVar[None] = None
    """An isotropic section is the same in every direction."""


@dataclass(frozen=True, eq=False)
class LaminateSection:
    """A laminate given by its A-B-D matrix.

        [N; M] = [A B; B D] [eps; kappa],   order xx, yy, xy (engineering shear, twice the twist)

    N and M are forces and moments per length, eps and kappa strain and curvature of the surface of the nodes.
    The section's x axis is `reference_direction` projected onto each element, its z axis the element normal.

    membrane, coupling, bending : (3, 3)    A N/m, B N, D N m, symmetric; A or D may be zero if B is zero
    mass_per_area : kg/m^2; 0 for statics alone
    rotary_inertia_per_area : second moment of the density over the thickness, about the nodes' surface, kg
    reference_direction : (3,)    of the section's x axis; `Section.directions` replaces it
    shear : (2, 2) or None    transverse shear stiffness, order xz, yz, N/m; None: rigid in shear
    thickness : float or None    m, for pictures only; None if unknown
    mass_offset : distance of the mass centre from the nodes, along the normal, m
    Raises ModelError for a matrix of wrong shape, not finite or not symmetric; an A-B-D matrix (without its
    zero rows) or shear stiffness that is not positive definite; a negative mass or inertia; a direction
    without length; a thickness that is not positive.
    Source: R. M. Jones, Mechanics of Composite Materials, 2nd ed. (1999), eq. (4.22)-(4.24).
    """

    membrane: FloatArray
    coupling: FloatArray
    bending: FloatArray
    mass_per_area: float
    rotary_inertia_per_area: float
    reference_direction: ArrayLike = (1.0, 0.0, 0.0)
    shear: FloatArray | None = None
    thickness: float | None = None
    mass_offset: float = 0.0

    def __post_init__(self) -> None:
        for name in ("membrane", "coupling", "bending"):
            matrix = stiffness_matrix(f"laminate {name} stiffness", getattr(self, name), 3)
            object.__setattr__(self, name, matrix)
        ABD = np.block([[self.membrane, self.coupling], [self.coupling, self.bending]])
        # A wall without bending stiffness, or without membrane stiffness, has a zero block in A-B-D.
        carried = np.repeat([self.membrane.any(), self.bending.any()], 3) | ABD.any(axis=0)
        ABD = ABD[np.ix_(carried, carried)] if carried.any() else ABD
        diagonal = np.diag(ABD)
        if diagonal.min() < 0:
            raise ModelError(
                f"the A-B-D matrix has a diagonal entry {diagonal.min():.3e}; none may be negative"
            )
        # A zero row is a direction without stiffness, which the check leaves out.
        resists = ABD.any(axis=1)
        lowest = lowest_scaled_eigenvalue(ABD[np.ix_(resists, resists)]) if resists.any() else 0.0
        if lowest < 1e-12:
            raise ModelError(
                f"the A-B-D matrix is not positive definite (lowest eigenvalue {lowest:.3e} when scaled to a "
                "unit diagonal): check the units and the sign of the coupling B"
            )
        check_not_negative(self, "{}", "mass_per_area", "rotary_inertia_per_area")
        if self.shear is not None:
            object.__setattr__(self, "shear", stiffness_matrix("laminate shear stiffness", self.shear, 2))
            if lowest_scaled_eigenvalue(self.shear) < 1e-12:
                raise ModelError("the laminate's shear stiffness is not positive definite; check its units")
        if self.thickness is not None and not (isfinite(self.thickness) and self.thickness > 0):
            raise ModelError(f"laminate thickness is {self.thickness}; it must be a positive finite length")
        if not isfinite(self.mass_offset):
            raise ModelError(f"mass_offset is {self.mass_offset}; give a finite length")
        direction = np.array(self.reference_direction, dtype=np.float64)
        length = np.linalg.norm(direction)
        if direction.shape != (3,) or not (isfinite(length) and length > 0):
            raise ModelError(f"reference_direction is {self.reference_direction}; give three finite numbers")
        direction /= length
        direction.setflags(write=False)
        object.__setattr__(self, "reference_direction", direction)


ShellSection = HomogeneousSection | LaminateSection
"""The section of a shell: its stiffnesses, and its mass and rotary inertia per area."""
