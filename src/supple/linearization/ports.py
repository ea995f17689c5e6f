"""Ports of a linearised machine: inputs and outputs at points of its bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from supple.body import InterfaceMotion
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


@dataclass(frozen=True)
class TranslationPort:
    """Displacement of an interface along a direction; as input, a force along it.

    at : At | "BODY.INTERFACE"
    direction : (3,)    global in the equilibrium; it rotates with a rotating body. Normalised.
    against : the end relative to which the motion is measured; the opposite force acts on it
    """

    at: At | Any
    direction: tuple[float, float, float]
    against: At | Any = GROUND

    def __post_init__(self) -> None:
        _check(self, "direction")

    @property
    def label(self) -> str:
        """Label of the interface and the direction."""
        return f"{self.at} along {direction_text(self.direction)}{_against(self)}"

    def row(self, machine: LinearMachine) -> Array:
        """`b` (k,), `b y` in units of length."""
        return _row(machine, self, self.direction, "velocity")


@dataclass(frozen=True)
class RotationPort:
    """Rotation of an interface about an axis; as input, a moment about it.

    The motor of a joint is a port on the joint's second end against its first end, about the joint's axis.

    at : At | "BODY.INTERFACE"
    axis : (3,)     global in the equilibrium; it rotates with a rotating body. Normalised.
    against : the end relative to which the motion is measured; the opposite moment acts on it
    """

    at: At | Any
    axis: tuple[float, float, float]
    against: At | Any = GROUND

    def __post_init__(self) -> None:
        _check(self, "axis")

    @property
    def label(self) -> str:
        """Label of the interface and the axis."""
        return f"{self.at} about {direction_text(self.axis)}{_against(self)}"

    def row(self, machine: LinearMachine) -> Array:
        """`b` (k,), `b y` in rad."""
        return _row(machine, self, self.axis, "angular_velocity")


def _check(port: Any, name: str) -> None:
    at, given = as_end(port.at), getattr(port, name)
    if at == GROUND:
        raise ModelError(
            "a port on the ground does not move: give an interface of a body. For a ground that accelerates "
            "take BaseAccelerationPort(direction) as input"
        )
    object.__setattr__(port, "at", at)
    object.__setattr__(port, "against", as_end(port.against))
    object.__setattr__(port, name, checked_direction(f"{name} of the port at '{at}'", given))


def checked_direction(what: str, given: Any) -> tuple[float, float, float]:
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


def _against(port: Any) -> str:
    return "" if port.against == GROUND else f" against {port.against}"


def _row(machine: LinearMachine, port: Any, along: tuple[float, float, float], of: str) -> Array:
    motion = getattr(_rates(machine, port.at), of)
    if port.against != GROUND:
        motion = motion - getattr(_rates(machine, port.against), of)
    return np.asarray(along) @ motion.T


def _rates(machine: LinearMachine, at: At) -> InterfaceMotion:
    """Motion of an interface for unit rate of each independent coordinate, (k, ...), global."""
    body = machine.system.placed(at.body, "port").body
    return body.interface_motion(machine.unit_rates.bodies[at.body], at.interface)
