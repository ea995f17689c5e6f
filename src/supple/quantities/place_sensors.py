"""Sensors at a place of a body: where it is, how it moves, how it is deflected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_sequence, check_text, given
from supple.body import NodeMotion
from supple.body.floating_kinematics import node_numbers
from supple.errors import ArgumentError, ModelError
from supple.integrate import Solution
from supple.machine import GROUND as THE_GROUND
from supple.machine import At, BaseAcceleration, System, as_end
from supple.quantities.end_motion import body_named, end_poses
from supple.quantities.reading import Channel, Quantity
from supple.quantities.sensor import vector_channels
from supple.quantities.tracked_motion import observer_of, tracked_motion

__all__ = [
    "AccelerationSensor",
    "AngularVelocitySensor",
    "DeflectionSensor",
    "Place",
    "PositionSensor",
    "VelocitySensor",
]

Array = NDArray[np.float64]
GLOBAL = "global"


@dataclass(frozen=True)
class Place:
    """A place of a body: an interface by its name, or the mean of some nodes by their numbers."""

    body: str
    at: str | tuple[int, ...]

    def __post_init__(self) -> None:
        check_text("Place, body", self.body, "the name of a body")
        if not isinstance(self.at, str):
            check_sequence("Place, at", self.at, "the name of an interface, or node numbers")
            object.__setattr__(self, "at", tuple(np.asarray(self.at).tolist()))

    def body_of(self, system: System, sensor: str) -> Any:
        """The form of the body; ModelError where the machine has none, or it has no such place."""
        body = body_named(system, self.body, sensor)
        if isinstance(self.at, str):
            body.interface(self.at)
        else:
            node_numbers(self.at, len(body.nodes))
        return body

    def motion(self, system: System, solution: Solution, sensor: str) -> NodeMotion:
        """Position, velocity and acceleration (t, 3) in space."""
        body, motion = body_named(system, self.body, sensor), solution.bodies[self.body]
        if isinstance(self.at, str):
            moving = body.interface_motion(motion, self.at)
            return NodeMotion(moving.position, moving.velocity, moving.acceleration)
        return NodeMotion(*(each.mean(axis=1) for each in body.node_motion(motion, self.at)))


def as_place(what: str, value: Any) -> Place:
    """The place meant by a `Place`, or by "BODY.INTERFACE" or an `At`, as of joints; or ArgumentError."""
    if isinstance(value, Place):
        return value
    if isinstance(value, At) or (isinstance(value, str) and "." in value):
        end = as_end(value)
        return Place(end.body, end.interface)
    expected = 'Place(body, at) with an interface or node numbers, or "BODY.INTERFACE"'
    raise ArgumentError(f"{what}: expected {expected}, got {given(value)}")


class _AtPlace:
    """What sensors at a place check when they are made."""

    name: str
    place: Place

    def __post_init__(self) -> None:
        kind = type(self).__name__
        check_text(f"{kind}, name", self.name, "the name of the sensor")
        object.__setattr__(self, "place", as_place(f"{kind} '{self.name}', place", self.place))


@dataclass(frozen=True)
class PositionSensor(_AtPlace):
    """Position of a place in space, (t, 3)."""

    name: str
    place: Place

    def channels(self, system: System) -> Sequence[Channel]:
        """x, y, z."""
        self.place.body_of(system, self.name)
        return vector_channels(Quantity.LENGTH, GLOBAL)

    def values(self, system: System, solution: Solution) -> Array:
        """R (t, 3)."""
        body = body_named(system, self.place.body, self.name)
        return tracked_motion(body, solution.bodies[self.place.body], self.place.at).position


@dataclass(frozen=True)
class VelocitySensor(_AtPlace):
    """Velocity of a place in space, (t, 3)."""

    name: str
    place: Place

    def channels(self, system: System) -> Sequence[Channel]:
        """x, y, z."""
        self.place.body_of(system, self.name)
        return vector_channels(Quantity.VELOCITY, GLOBAL)

    def values(self, system: System, solution: Solution) -> Array:
        """dr/dt (t, 3)."""
        return self.place.motion(system, solution, self.name).velocity


@dataclass(frozen=True)
class AccelerationSensor(_AtPlace):
    """Acceleration of a place in space, (t, 3); an accelerometer shows it less gravity, in its own axes.

    Where the base of the machine accelerates (`BaseAcceleration`), positions and velocities are those seen
    from it; the acceleration has that of the base added.
    """

    name: str
    place: Place

    def channels(self, system: System) -> Sequence[Channel]:
        """x, y, z."""
        self.place.body_of(system, self.name)
        return vector_channels(Quantity.ACCELERATION, GLOBAL)

    def values(self, system: System, solution: Solution) -> Array:
        """d2r/dt2 (t, 3)."""
        seen_from_base = self.place.motion(system, solution, self.name).acceleration
        if np.isnan(seen_from_base).all():
            raise ModelError(
                f"sensor '{self.name}': the motion of body '{self.place.body}' has no accelerations: it is a "
                "part of an explicit march, or was recorded by an earlier version; then run the case again"
            )
        return seen_from_base + base_acceleration(system, solution.times)


def base_acceleration(system: System, times: Array) -> Array:
    """Acceleration of the base on which a machine stands at some times, (t, 3), global."""
    bases = [load.law for load in system.loads if isinstance(load, BaseAcceleration)]
    total = np.zeros((len(times), 3))
    for law in bases:
        total += np.asarray(jax.vmap(lambda time, law=law: jnp.asarray(law(time), dtype=float))(times))
    return total


@dataclass(frozen=True)
class AngularVelocitySensor:
    """Angular velocity of an interface, global components, (t, 3)."""

    name: str
    at: At

    def __post_init__(self) -> None:
        check_text("AngularVelocitySensor, name", self.name, "the name of the sensor")
        if not isinstance(self.at, At):
            object.__setattr__(self, "at", as_end(self.at))

    def channels(self, system: System) -> Sequence[Channel]:
        """x, y, z."""
        if self.at != THE_GROUND:
            body_named(system, self.at.body, self.name).interface(self.at.interface)
        return vector_channels(Quantity.ANGULAR_VELOCITY, GLOBAL)

    def values(self, system: System, solution: Solution) -> Array:
        """W (t, 3)."""
        still = np.zeros(3)
        return np.asarray(end_poses(system, solution, self.at, np.eye(3), still, self.name).angular_velocity)


@dataclass(frozen=True)
class DeflectionSensor(_AtPlace):
    """Displacement of a place as seen from an interface, in the mesh axes that turn with it, (t, 3).

    seen_from : At | None   the body's first interface where it is left out
    """

    name: str
    place: Place
    seen_from: At | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.seen_from is not None:
            object.__setattr__(self, "seen_from", as_end(self.seen_from))

    def channels(self, system: System) -> Sequence[Channel]:
        """x, y, z."""
        self.place.body_of(system, self.name)
        return vector_channels(Quantity.LENGTH, f"mesh axes turning with {self._base(system)}")

    def values(self, system: System, solution: Solution) -> Array:
        """`A_p^T (r - r_p) - (x - x_p)`, (t, 3)."""
        body = body_named(system, self.place.body, self.name)
        base = self._base(system)
        seen = observer_of(system, solution, self.place.body, {} if base is None else {self.place.body: base})
        return tracked_motion(body, solution.bodies[self.place.body], self.place.at, seen).deflection

    def _base(self, system: System) -> At | None:
        if self.seen_from is not None:
            return self.seen_from
        body = body_named(system, self.place.body, self.name)
        return At(self.place.body, body.interfaces[0].name) if body.interfaces else None
