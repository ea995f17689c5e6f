"""Beam sections: flexibility and inertia per length of the cross-section of a beam.

Every section returns matrices (6, 6) at positions along the beam, in its axes x (along), y and z. The
flexibility is in the order of N, V_y, V_z, M_x, M_y, M_z; the inertia is along x, y, z, then about x, y, z.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.algebra.cross import cross_matrix
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem.material import Isotropic, check_not_negative, lowest_scaled_eigenvalue, stiffness_matrix
from supple.mesh import SectionGeometry

__all__ = ["BeamSection", "CoupledBeamSection", "LineSection", "RodSection"]

N, VY, VZ, MX, MY, MZ = range(6)


@dataclass(frozen=True, eq=False)
class BeamSection:
    """A section about its shear centre; y is `orientation` projected normal to the beam.

    Parameters
    ----------
    area : float                        m^2
    I1, I2 : float                      second moments for bending in the x-y and in the x-z plane, m^4
    J : float                           torsion constant, m^4; where I1, I2 or J is 0, its moment is zero
    K1, K2 : float                      shear factors of the two planes; 0 for no shear deformation
    orientation : float array (3,)      a direction in the x-y plane, in the mesh axes; `Section.directions`
                                                 overrides it
    mass_per_length : float or None     kg/m; density times area when None
    I12 : float                         int y z dA, m^4; 0 in principal axes
    neutral : (y, z)                    position of the neutral axis from the shear centre, m
    mass_centre : (y, z)                position of the mass centre from the shear centre, m
    rotary : float array (3,) or None   inertia per length about x, y, z through the mass centre, kg m;
             density times I1 + I2, I2, I1 (and -I12 between y and z) when None
    second : BeamSection or None        the section at the second end of a tapered beam; the values above and
             the inertia matrix vary linearly between the ends
    geometry : SectionGeometry or None  its outline and the points of stress recovery

    Raises
    ------
    ModelError   an area that is not positive; negative second moments, factors or masses; values that are not
                 finite; I12^2 not below I1 I2; a direction of length zero
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
    I12: float = 0.0
    neutral: tuple[float, float] = (0.0, 0.0)
    mass_centre: tuple[float, float] = (0.0, 0.0)
    rotary: ArrayLike | None = None
    second: BeamSection | None = None
    geometry: SectionGeometry | None = None

    def __post_init__(self) -> None:
        if self.mass_per_length is None:
            object.__setattr__(self, "mass_per_length", self.material.density * self.area)
        if not (isfinite(self.area) and self.area > 0):
            raise ModelError(f"beam section: area is {self.area}; it must be positive and finite")
        check_not_negative(self, "beam section: {}", "I1", "I2", "J", "mass_per_length")
        for name in ("K1", "K2"):
            value = getattr(self, name)
            if not (isfinite(value) and value >= 0):
                raise ModelError(
                    f"beam section: the shear factor {name} is {value}; give a positive one, or 0 for none"
                )
        if self.I12 and not self.I12**2 < self.I1 * self.I2:
            raise ModelError(
                f"beam section: I12 is {self.I12}; its square must be below I1 I2 = {self.I1 * self.I2:.6g}"
            )
        for name in ("neutral", "mass_centre"):
            if np.shape(getattr(self, name)) != (2,) or not np.isfinite(getattr(self, name)).all():
                raise ModelError(f"beam section: {name} is {getattr(self, name)}; give two finite lengths")
        if self.rotary is not None:
            rotary = np.array(self.rotary, dtype=np.float64)
            if rotary.shape != (3,) or not (np.isfinite(rotary).all() and rotary.min() >= 0):
                raise ModelError(
                    f"beam section: rotary is {self.rotary}; give three finite numbers, none negative"
                )
            rotary.setflags(write=False)
            object.__setattr__(self, "rotary", rotary)
        if self.second is not None and _moduli(self.material) != _moduli(self.second.material):
            raise ModelError(
                "beam section: its second end has other moduli; a tapered beam has one elastic material, so "
                "scale area, I1, I2 and J of the second section instead"
            )
        object.__setattr__(self, "orientation", _direction(self.orientation))

    @property
    def carried(self) -> NDArray[np.bool_]:
        """Which of N, V_y, V_z, M_x, M_y, M_z the section carries; forces not carried are zero."""
        ends = (self, self.second or self)
        Mx, My, Mz = (all(getattr(end, name) > 0 for end in ends) for name in ("J", "I2", "I1"))
        return np.array([True, Mz, My, Mx, My, Mz])

    def flexibility(self, places: FloatArray) -> FloatArray:
        """Flexibility (p, 6, 6), from forces to strains and curvatures, at fractions (p,) of the length.

        About the neutral axis, the entries are 1/EA, the inverse of E [I2 -I12; -I12 I1], 1/(K G A) and 1/GJ.
        An eccentric neutral axis makes a force N at the shear centre cause bending. Rows of forces that the
        section does not carry are zero.
        """
        return np.array([_flexibility(self._at(s)) for s in places])

    def inertia(self, places: FloatArray) -> FloatArray:
        """Mass per length (p, 6, 6) for motions of the shear centre, at fractions (p,) of the length."""
        return _between(_inertia(self), _inertia(self.second or self), places)

    def _at(self, s: float) -> BeamSection:
        if self.second is None:
            return self
        names = ("area", "I1", "I2", "J", "K1", "K2", "I12", "neutral")
        between: dict[str, Any] = {
            name: (1 - s) * np.asarray(getattr(self, name)) + s * np.asarray(getattr(self.second, name))
            for name in names
        }
        return replace(self, **between, second=None)


@dataclass(frozen=True, eq=False)
class CoupledBeamSection:
    """A beam section given by full matrices, as from section analysis programs and blade tables.

    Parameters
    ----------
    stiffness : float array (6, 6)      from strains and curvatures to forces N V_y V_z and moments
                                        M_x M_y M_z, about the beam's axis; N, N m, N m^2
    mass : float array (6, 6)           mass per length for motions of the axis; kg/m, kg, kg m
    orientation : float array (3,)      a direction in the x-y plane; `Section.directions` overrides it
    second : CoupledBeamSection or None     the section at the second end; matrices vary linearly in between

    Raises
    ------
    ModelError   matrices of another shape, not finite, not symmetric; a stiffness that is not positive
                 definite, a mass with a negative eigenvalue; a direction of length zero
    """

    stiffness: FloatArray
    mass: FloatArray
    orientation: ArrayLike = (0.0, 0.0, 1.0)
    second: CoupledBeamSection | None = None

    def __post_init__(self) -> None:
        for name in ("stiffness", "mass"):
            matrix = stiffness_matrix(f"beam section: {name}", getattr(self, name), 6)
            object.__setattr__(self, name, matrix)
        if lowest_scaled_eigenvalue(self.stiffness) < 1e-12:
            raise ModelError(
                "beam section: the stiffness is not positive definite; check units and order of its rows "
                "(N, V_y, V_z, M_x, M_y, M_z)"
            )
        if np.linalg.eigvalsh(self.mass)[0] < -1e-9 * np.abs(self.mass).max():
            raise ModelError("beam section: the mass matrix has a negative eigenvalue; check its mass centre")
        object.__setattr__(self, "orientation", _direction(self.orientation))

    @property
    def carried(self) -> NDArray[np.bool_]:
        """Which of N, V_y, V_z, M_x, M_y, M_z the section carries: all."""
        return np.ones(6, dtype=bool)

    def flexibility(self, places: FloatArray) -> FloatArray:
        """Flexibility (p, 6, 6), from forces to strains and curvatures, at fractions (p,) of the length."""
        stiffness = _between(self.stiffness, (self.second or self).stiffness, places)
        return np.linalg.inv(stiffness).astype(np.float64)

    def inertia(self, places: FloatArray) -> FloatArray:
        """Mass per length (p, 6, 6) for motions of the axis, at fractions (p,) of the length."""
        return _between(self.mass, (self.second or self).mass, places)


LineSection = BeamSection | CoupledBeamSection
"""The section of a beam."""


@dataclass(frozen=True)
class RodSection:
    """A bar that carries axial force and torsion alone.

    area : m^2
    J : torsion constant, m^4; 0 for none
    mass_per_length : float or None    kg/m; density times area when None
    torsion_arm : c of the shear stress c M_x / J, m; 0 to omit this stress
    Raises ModelError for values that are negative or not finite; an area that is not positive.
    """

    material: Isotropic
    area: float
    J: float = 0.0
    mass_per_length: float | None = None
    torsion_arm: float = 0.0

    def __post_init__(self) -> None:
        if self.mass_per_length is None:
            object.__setattr__(self, "mass_per_length", self.material.density * self.area)
        if not (isfinite(self.area) and self.area > 0):
            raise ModelError(f"rod: area is {self.area}; it must be positive and finite")
        check_not_negative(self, "rod: {}", "J", "mass_per_length", "torsion_arm")


def _flexibility(section: BeamSection) -> FloatArray:
    E, G = section.material.youngs_modulus, section.material.shear_modulus
    flexibility = np.zeros((6, 6))
    flexibility[N, N] = 1 / (E * section.area)
    for row, factor in ((VY, section.K1), (VZ, section.K2)):
        flexibility[row, row] = 1 / (factor * G * section.area) if factor else 0.0
    flexibility[MX, MX] = 1 / (G * section.J) if section.J else 0.0
    if section.I1 and section.I2:
        moments = np.array([[section.I2, -section.I12], [-section.I12, section.I1]])
        flexibility[MY:, MY:] = np.linalg.inv(E * moments)
    else:
        flexibility[MY, MY] = 1 / (E * section.I2) if section.I2 else 0.0
        flexibility[MZ, MZ] = 1 / (E * section.I1) if section.I1 else 0.0
    about_neutral = np.eye(6)
    about_neutral[MZ, N], about_neutral[MY, N] = section.neutral[0], -section.neutral[1]
    return about_neutral.T @ flexibility @ about_neutral


def _inertia(section: BeamSection) -> FloatArray:
    mass, I1, I2 = section.mass_per_length, section.I1, section.I2
    assert mass is not None  # set when left out
    arm = cross_matrix(np.array([0.0, *section.mass_centre]))
    if section.rotary is None:
        moments = np.array([[I1 + I2, 0, 0], [0, I2, -section.I12], [0, -section.I12, I1]])
        about_centre = section.material.density * moments
    else:
        about_centre = np.diag(section.rotary)
    return np.block([[mass * np.eye(3), -mass * arm], [mass * arm, about_centre - mass * arm @ arm]])


def _moduli(material: Isotropic) -> tuple[float, float]:
    return material.youngs_modulus, material.shear_modulus


def _between(first: FloatArray, second: FloatArray, places: FloatArray) -> FloatArray:
    return first + places[:, None, None] * (second - first)


def _direction(given: ArrayLike) -> FloatArray:
    direction = np.array(given, dtype=np.float64)
    if direction.shape != (3,) or not np.isfinite(direction).all() or not direction.any():
        raise ModelError(f"beam section: orientation is {given}; give three finite numbers, not all zero")
    direction.setflags(write=False)
    return direction
