"""Sensors at a place of a body: where it is, how it moves, how it is deflected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.integrate import Solution
from supple.machine import At, BaseAcceleration, System
from supple.results.node_motion import NodeMotion, moving_point, node_motion
from supple.results.tracked_motion import observer_of, tracked_motion
from supple.sensors.end_motion import body_named, end_poses, floating_motion
from supple.sensors.reading import Channel, Quantity
from supple.sensors.sensor import vector_channels

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

    def motion(self, system: System, solution: Solution, sensor: str) -> NodeMotion:
        """Position, velocity and acceleration (t, 3) in space, of a body in a floating frame."""
        body = body_named(system, self.body, sensor)
        motion = floating_motion(solution, self.body, sensor)
        if isinstance(self.at, str):
            return moving_point(body.interface(self.at), motion)
        return NodeMotion(*(each.mean(axis=1) for each in node_motion(body, motion, self.at)))


@dataclass(frozen=True)
class PositionSensor:
    """Position of a place in space, (t, 3)."""

    name: str
    place: Place

    def channels(self, _: System) -> Sequence[Channel]:
        """x, y, z."""
        return vector_channels(Quantity.LENGTH, GLOBAL)

    def values(self, system: System, solution: Solution) -> Array:
        """R (t, 3)."""
        body = body_named(system, self.place.body, self.name)
        return tracked_motion(body, solution.bodies[self.place.body], self.place.at).position


@dataclass(frozen=True)
class VelocitySensor:
    """Velocity of a place in space, (t, 3)."""

    name: str
    place: Place

    def channels(self, _: System) -> Sequence[Channel]:
        """x, y, z."""
        return vector_channels(Quantity.VELOCITY, GLOBAL)

    def values(self, system: System, solution: Solution) -> Array:
        """dr/dt (t, 3)."""
        return self.place.motion(system, solution, self.name).velocity


@dataclass(frozen=True)
class AccelerationSensor:
    """Acceleration of a place in space, (t, 3); an accelerometer shows it less gravity, in its own axes.

    Where the base of the machine accelerates (`BaseAcceleration`), positions and velocities are those seen
    from it; the acceleration has that of the base added.
    """

    name: str
    place: Place

    def channels(self, _: System) -> Sequence[Channel]:
        """x, y, z."""
        return vector_channels(Quantity.ACCELERATION, GLOBAL)

    def values(self, system: System, solution: Solution) -> Array:
        """d2r/dt2 (t, 3)."""
        seen_from_base = self.place.motion(system, solution, self.name).acceleration
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

    def channels(self, _: System) -> Sequence[Channel]:
        """x, y, z."""
        return vector_channels(Quantity.ANGULAR_VELOCITY, GLOBAL)

    def values(self, system: System, solution: Solution) -> Array:
        """W (t, 3)."""
        still = np.zeros(3)
        return np.asarray(end_poses(system, solution, self.at, np.eye(3), still, self.name).angular_velocity)


@dataclass(frozen=True)
class DeflectionSensor:
    """Displacement of a place as seen from an interface, in the mesh axes that turn with it, (t, 3).

    seen_from : At | None   the body's first interface where it is left out
    """

    name: str
    place: Place
    seen_from: At | None = None

    def channels(self, system: System) -> Sequence[Channel]:
        """x, y, z."""
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
