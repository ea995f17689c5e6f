"""Beam sections: what a beam is made of across its axis, as stiffness and inertia per length."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.errors import ModelError
from supple.fem.material import Isotropic

__all__ = ["BeamSection"]


@dataclass(frozen=True, eq=False)
class BeamSection:
    """A constant section with its principal axes y and z; y is `orientation` without its part along the beam.

    Parameters
    ----------
    material : Isotropic
    area : float                        m^2
    I1, I2 : float                      second moments for bending in the x-y and in the x-z plane, m^4
    J : float                           torsion constant, m^4
    K1, K2 : float                      shear factors of the two planes; 0 for no shear deformation
    orientation : float array (3,)      a direction in the x-y plane, in the mesh axes
    mass_per_length : float or None     kg/m; density times area when None

    Raises
    ------
    ModelError   values that are not finite or not positive; a direction of length zero
    """

    material: Isotropic
    area: float
    I1: float
    I2: float
    J: float
    K1: float = 0.0
    K2: float = 0.0
    orientation: ArrayLike = (0.0, 0.0, 1.0)
    mass_per_length: float | None = None

    def __post_init__(self) -> None:
        if self.mass_per_length is None:
            object.__setattr__(self, "mass_per_length", self.material.density * self.area)
        for name in ("area", "I1", "I2", "J", "mass_per_length"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0):
                raise ModelError(f"beam section: {name} is {value}; it must be positive and finite")
        for name in ("K1", "K2"):
            value = getattr(self, name)
            if not (isfinite(value) and value >= 0):
                raise ModelError(
                    f"beam section: the shear factor {name} is {value}; give a positive one, or 0 for none"
                )
        direction = np.array(self.orientation, dtype=np.float64)
        if direction.shape != (3,) or not np.isfinite(direction).all() or not direction.any():
            raise ModelError(
                f"beam section: orientation is {self.orientation}; give three finite numbers, not all zero"
            )
        direction.setflags(write=False)
        object.__setattr__(self, "orientation", direction)

    @property
    def rotary_inertia_per_length(self) -> NDArray[np.float64]:
        """Inertia about the section's axes x, y, z (3,), kg m."""
        return self.material.density * np.array([self.I1 + self.I2, self.I2, self.I1])
