"""Rigid bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.algebra import read_only
from supple.errors import ModelError

# Inertias typed with a few digits may break the triangle inequality in the last one (thin discs, rods).
ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A body without deformation.

    Parameters
    ----------
    mass       : kg, positive
    centre     : (3,) centre of mass in body axes, m
    inertia    : (3, 3) about the centre of mass, body axes, kg m^2; symmetric, positive definite
    interfaces : name -> (3,) position in body axes, m
    Raises
    ------
    ModelError   mass or inertia that no matter can have; positions that are not three finite numbers
    """

    name: str
    mass: float
    centre: NDArray[np.float64]
    inertia: NDArray[np.float64]
    interfaces: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.mass) and self.mass > 0):
            raise ModelError(f"rigid body '{self.name}': the mass is {self.mass}; it must be positive")
        object.__setattr__(self, "inertia", self._checked_inertia())
        object.__setattr__(self, "centre", self._position("centre", self.centre))
        places = {
            name: self._position(f"interface '{name}'", place) for name, place in self.interfaces.items()
        }
        object.__setattr__(self, "interfaces", MappingProxyType(places))

    def __reduce__(self):
        # Mapping proxies do not pickle.
        return RigidBody, (self.name, self.mass, self.centre, self.inertia, dict(self.interfaces))

    def interface(self, name: str) -> NDArray[np.float64]:
        """Position of an interface; ModelError lists those there are."""
        if name not in self.interfaces:
            known = ", ".join(f"'{known}'" for known in self.interfaces) or "none"
            raise ModelError(f"rigid body '{self.name}' has no interface '{name}'; it has {known}")
        return self.interfaces[name]

    def _position(self, what: str, given: ArrayLike) -> NDArray[np.float64]:
        position = read_only(given)
        if position.shape != (3,) or not np.all(np.isfinite(position)):
            raise ModelError(f"rigid body '{self.name}': {what} must be three finite numbers, not {given}")
        return position

    def _checked_inertia(self) -> NDArray[np.float64]:
        inertia = read_only(self.inertia)
        where = f"rigid body '{self.name}': the inertia"
        if inertia.shape != (3, 3) or not np.all(np.isfinite(inertia)):
            raise ModelError(f"{where} must be a (3, 3) array of finite numbers, not {self.inertia}")
        if np.max(np.abs(inertia - inertia.T)) > ROUNDING * np.max(np.abs(inertia)):
            raise ModelError(f"{where} is not symmetric: {inertia.tolist()}")
        smallest, middle, largest = np.linalg.eigvalsh(0.5 * (inertia + inertia.T))
        if smallest <= 0:
            raise ModelError(
                f"{where} is not positive definite: its smallest principal value is {smallest:.6g}"
            )
        if largest > (smallest + middle) * (1 + ROUNDING):
            raise ModelError(
                f"{where} breaks the triangle inequality: {largest:.6g} > {smallest:.6g} + {middle:.6g}; no "
                "distribution of mass has these principal values"
            )
        return inertia
