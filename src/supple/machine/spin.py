"""Steady rotation of a machine: its axis, its rate, and its rotating bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from supple.algebra import read_only
from supple.arguments import check_number, check_sequence
from supple.errors import ModelError
from supple.machine.system import System, space_vector

__all__ = ["Spin"]


@dataclass(frozen=True, eq=False)
class Spin:
    """A steady rotation about an axis fixed in space.

        dR/dt = w x (R - p),        w = rate * axis,        for a point R of a rotating body

    Parameters
    ----------
    rate : float    angular velocity, rad/s; may be negative
    axis : (3,)     direction, global components, of any length; it is normalised
    point : (3,)    p, any point on the axis
    bodies : names of the rotating bodies; default: all bodies

    Raises
    ------
    ModelError      a rate that is not finite, or an axis that is zero
    """

    rate: float
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    point: np.ndarray = field(default_factory=lambda: np.zeros(3))
    bodies: Sequence[str] | None = None

    def __post_init__(self) -> None:
        check_number("Spin, rate", self.rate)
        if not np.isfinite(self.rate):
            raise ModelError(f"the rate of a spin is {self.rate}: give a finite rate, in rad/s")
        for name in ("axis", "point"):
            object.__setattr__(self, name, space_vector(f"{name} of a spin", getattr(self, name)))
        length = float(np.linalg.norm(self.axis))
        if not length > 0:
            raise ModelError("the axis of a spin is (0, 0, 0): give a direction")
        object.__setattr__(self, "axis", read_only(self.axis / length))
        if self.bodies is not None:
            check_sequence("Spin, bodies", self.bodies, "a list of names, also of a single one")
            object.__setattr__(self, "bodies", tuple(self.bodies))

    def angular_velocities(self, system: System) -> np.ndarray:
        """Angular velocity of every body, (nb, 3), global; zero for bodies that do not rotate.

        Raises ModelError for a name that no body has.
        """
        names = [placed.body.name for placed in system.bodies] if self.bodies is None else self.bodies
        velocities = np.zeros((len(system.bodies), 3))
        velocities[[system.body_index(name, "spin") for name in names]] = self.rate * self.axis
        return velocities
