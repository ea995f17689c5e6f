"""Rigid bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.algebra import read_only
from supple.arguments import check_fields, check_numbers, check_text
from supple.body.interface import PointInterface, interface_named
from supple.body.point_motion import FloatingForm
from supple.errors import ModelError
from supple.summary import Summarized, Summary, place_text

__all__ = ["RigidBody"]

# Largest accepted relative asymmetry of an inertia, and relative violation of the triangle inequality. An
# inertia given with few digits can have both in its last digit (thin disc, rod).
ROUNDING = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class RigidBody(FloatingForm, Summarized):
    """A body without deformation.

    Parameters
    ----------
    mass       : kg, positive
    centre     : (3,) centre of mass in body axes, m
    inertia    : (3, 3) about the centre of mass, body axes, kg m^2; symmetric, positive definite, with no
        principal moment larger than the sum of the other two
    points     : {interface name: (3,) position in body axes, m}
    Raises
    ------
    ModelError   a mass or an inertia that violates these conditions; a position that is not three finite
                 numbers
    """

    name: str
    mass: float
    centre: NDArray[np.float64]
    inertia: NDArray[np.float64]
    points: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_fields(self)
        check_text("RigidBody, name", self.name)
        if not (np.isfinite(self.mass) and self.mass > 0):
            raise ModelError(f"rigid body '{self.name}': the mass is {self.mass}; it must be positive")
        object.__setattr__(self, "inertia", self._checked_inertia())
        object.__setattr__(self, "centre", self._position("centre", self.centre))
        points = {name: self._position(f"interface '{name}'", place) for name, place in self.points.items()}
        object.__setattr__(self, "points", MappingProxyType(points))

    def summary(self) -> Summary:
        """Mass, centre of mass, principal moments of inertia and interfaces."""
        moments = ", ".join(f"{value:g}" for value in np.linalg.eigvalsh(self.inertia))
        rows = [
            ("mass", f"{self.mass:g}"),
            ("centre", place_text(self.centre)),
            ("principal moments", moments),
        ]
        rows += [(f"interface {name}", f"at {place_text(place)}") for name, place in self.points.items()]
        return Summary(f"RigidBody '{self.name}', mass {self.mass:g}", rows)

    def __reduce__(self):
        # A mapping proxy cannot be pickled.
        return RigidBody, (self.name, self.mass, self.centre, self.inertia, dict(self.points))

    kind: ClassVar[Literal["rigid"]] = "rigid"
    """The name of this form, "rigid"."""

    @property
    def centre_of_mass(self) -> NDArray[np.float64]:
        """Centre of mass (3,) in the body's frame, m."""
        return self.centre

    n_coordinates: ClassVar[int] = 0
    """A rigid body has no deformation coordinates."""

    @property
    def nodes(self) -> NDArray[np.float64]:
        """Positions (N, 3) of the interfaces in the body's frame, m."""
        return read_only(np.array(list(self.points.values())).reshape(-1, 3))

    @property
    def interfaces(self) -> tuple[PointInterface, ...]:
        """The points as interfaces, in the order given."""
        return tuple(PointInterface(name, position) for name, position in self.points.items())

    def interface(self, name: str) -> PointInterface:
        """The interface of that name; the ModelError for an unknown name lists the nearest name, or all."""
        return interface_named(self.name, name, self.interfaces)

    def expand(
        self, coordinates: ArrayLike, nodes: NDArray[np.intp] | slice = slice(None)
    ) -> NDArray[np.float64]:
        """Zero displacements (..., k, 3) of k nodes, for coordinates (..., 0)."""
        return np.zeros((*np.shape(coordinates)[:-1], len(self.nodes[nodes]), 3))

    def nodal_fields(
        self, coordinates: NDArray[np.float64], freedoms: NDArray[np.intp] | slice = slice(None)
    ) -> tuple[NDArray[np.float64], None]:
        """Zero displacements (3 N, t) of all or some freedoms; None, as no motion is condensed."""
        return np.zeros((self.nodes.size, len(coordinates)))[freedoms], None

    is_linear: ClassVar[bool] = True
    """There is no internal force."""

    def lowest_frequency(self) -> float:
        """Infinite: a rigid body has no vibration."""
        return np.inf

    rotation_limit: ClassVar[float] = np.inf
    """A rigid body has no rotation relative to its frame."""

    def _position(self, what: str, given: ArrayLike) -> NDArray[np.float64]:
        check_numbers(f"rigid body '{self.name}', {what}", given)
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
            raise ModelError(f"{where} is not symmetric; correct it: {inertia.tolist()}")
        smallest, middle, largest = np.linalg.eigvalsh(0.5 * (inertia + inertia.T))
        if smallest <= 0:
            raise ModelError(
                f"{where} is not positive definite, smallest principal value {smallest:.6g}; correct it"
            )
        if largest > (smallest + middle) * (1 + ROUNDING):
            raise ModelError(
                f"{where} breaks the triangle inequality: {largest:.6g} > {smallest:.6g} + {middle:.6g}; no "
                "distribution of mass has these principal values"
            )
        return inertia
