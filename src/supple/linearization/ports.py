"""Ports of a linearised machine: inputs and outputs at points of its bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from supple.errors import ModelError
from supple.linearization.linear_machine import Array, LinearMachine
from supple.machine import GROUND, At, as_end

__all__ = ["Port", "RotationPort", "TranslationPort"]


class Port(Protocol):
    """One scalar motion of a machine, and the force conjugate to it."""

    @property
    def label(self) -> str:
        """Name of the port in tables and files."""
        ...

    def row(self, machine: LinearMachine) -> Array:
        """`b` (k,): the motion is `b y`, its force enters as `b^T f`."""
        ...


class _EndPort:
    """A motion of an interface along or about a vector."""

    at: At | Any
    against: At | Any
    _vector: ClassVar[str]
    """Name of the field with the vector"""
    _word: ClassVar[str]
    _rate: ClassVar[str]
    """Name of the rate in an `InterfaceMotion`"""

    def __post_init__(self) -> None:
        at = as_end(self.at)
        if at == GROUND:
            raise ModelError(
                "a port on the ground does not move: give an interface of a body. For a ground that "
                "accelerates take BaseAccelerationPort(direction) as input"
            )
        unit = checked_direction(f"{self._vector} of the port at '{at}'", getattr(self, self._vector))
        for name, value in (("at", at), ("against", as_end(self.against)), (self._vector, unit)):
            object.__setattr__(self, name, value)

    @property
    def label(self) -> str:
        """Label of the interface and the vector."""
        against = "" if self.against == GROUND else f" against {self.against}"
        return f"{self.at} {self._word} {direction_text(getattr(self, self._vector))}{against}"

    def row(self, machine: LinearMachine) -> Array:
        """`b` (k,), `b y` in units of length, or in rad."""
        motion = self._rates(machine, self.at)
        if self.against != GROUND:
            motion = motion - self._rates(machine, self.against)
        return np.asarray(getattr(self, self._vector)) @ motion.T

    def _rates(self, machine: LinearMachine, at: At) -> Array:
        """Rates (k, 3) of an interface for unit rate of each independent coordinate, global."""
        body = machine.system.placed(at.body, "port").body
        return getattr(body.interface_motion(machine.unit_rates.bodies[at.body], at.interface), self._rate)


@dataclass(frozen=True)
class TranslationPort(_EndPort):
    """Displacement of an interface along a direction; as input, a force along it.

    at : At | "BODY.INTERFACE"
    direction : (3,)    global in the equilibrium; it rotates with a rotating body. Normalised.
    against : the end relative to which the motion is measured; the opposite force acts on it
    """

    _vector, _word, _rate = "direction", "along", "velocity"

    at: At | Any
    direction: tuple[float, float, float]
    against: At | Any = GROUND


@dataclass(frozen=True)
class RotationPort(_EndPort):
    """Rotation of an interface about an axis; as input, a moment about it.

    The motor of a joint is a port on the joint's second end against its first end, about the joint's axis.

    at : At | "BODY.INTERFACE"
    axis : (3,)     global in the equilibrium; it rotates with a rotating body. Normalised.
    against : the end relative to which the motion is measured; the opposite moment acts on it
    """

    _vector, _word, _rate = "axis", "about", "angular_velocity"

    at: At | Any
    axis: tuple[float, float, float]
    against: At | Any = GROUND


def checked_direction(what: str, given: ArrayLike) -> tuple[float, float, float]:
    """A unit vector; ModelError unless three finite numbers are given that are not all zero."""
    vector = np.array(given, dtype=float)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not vector.any():
        raise ModelError(f"{what} must be three numbers, not all zero, got {given}")
    x, y, z = (vector / np.linalg.norm(vector)).tolist()
    return x, y, z


def direction_text(vector: tuple[float, float, float]) -> str:
    """Name of an axis, such as `-z`, or the components of another unit vector."""
    for name, axis in zip("xyz", np.eye(3), strict=True):
        for sign in ("", "-"):
            if np.allclose(vector, -axis if sign else axis):
                return sign + name
    return "(" + ", ".join(f"{part:.4g}" for part in vector) + ")"
