"""Sensors at a place of a body: position, motion, deflection."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import check_text
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.integrate import FramedMotion, Solution
from supple.machine import GROUND, At, BaseAcceleration, System, as_end
from supple.quantities.place import Place, as_place, body_named
from supple.quantities.quantity_of_interest import largest_displacement
from supple.quantities.reading import Channel, QuantityKind, vector_channels
from supple.quantities.tracked_motion import observer_of, tracked_motion

__all__ = [
    "AccelerationSensor",
    "AngularVelocitySensor",
    "DeflectionSensor",
    "PositionSensor",
    "VelocitySensor",
]


@dataclass(frozen=True)
class _AtPlace:
    """A vector at a place, global components x, y, z."""

    name: str
    place: Place | Any

    quantity: ClassVar[QuantityKind]

    def __post_init__(self) -> None:
        kind = type(self).__name__
        check_text(f"{kind}, name", self.name, "the name of the sensor")
        object.__setattr__(self, "place", as_place(f"{kind} '{self.name}', place", self.place))

    def channels(self, system: System) -> Sequence[Channel]:
        """x, y, z."""
        self.place.body_of(system, self.name)
        return vector_channels("global", {"": self.quantity})


class PositionSensor(_AtPlace):
    """Position of a place in space, (t, 3); as a quantity of interest, the positions of its nodes."""

    quantity = QuantityKind.LENGTH

    def values(self, system: System, solution: Solution) -> FloatArray:
        """R (t, 3)."""
        return self.place.point(body_named(system, self.body, self.name), solution.bodies[self.body])

    @property
    def body(self) -> str:
        """Body of the place."""
        return self.place.body

    @property
    def words(self) -> str:
        """Description of the quantity and its norm."""
        norm = "" if isinstance(self.place.at, str) or len(self.place.at) == 1 else "RMS over its nodes, "
        return f"position of {self.name}: {norm}largest over the run"

    def at_points(self, system: System, solution: Solution) -> FloatArray:
        """Positions (t, k, 3) of the nodes, or of the interface."""
        return self.place.points(body_named(system, self.body, self.name), solution.bodies[self.body])

    def size(self, system: System, solution: Solution) -> float:
        """Largest displacement from the first interface, of the nodes; for an interface, of all nodes.

        For a rigid body: the largest displacement of the nodes of all elastic bodies; in a machine without
        elastic bodies, that of the place since the start.
        """
        form, nodes = body_named(system, self.body, self.name), self.place.at
        if not form.n_coordinates:
            elastic = [each.body for each in system.bodies if each.body.n_coordinates and each.body.has_frame]
            moved = [solution.motion(each.name, FramedMotion).coordinates for each in elastic]
            sizes = [largest_displacement(*each) for each in zip(elastic, moved, strict=True)]
            if sizes:
                return max(sizes)
            places = self.values(system, solution)
            return float(np.linalg.norm(places - places[0], axis=1).max())
        some = slice(None) if isinstance(nodes, str) else np.array(nodes)
        return largest_displacement(form, solution.motion(self.body, FramedMotion).coordinates, some)


class VelocitySensor(_AtPlace):
    """Velocity of a place in space, (t, 3)."""

    quantity = QuantityKind.VELOCITY

    def values(self, system: System, solution: Solution) -> FloatArray:
        """dr/dt (t, 3)."""
        return self.place.motion(system, solution, self.name).velocity


class AccelerationSensor(_AtPlace):
    """Acceleration of a place in space, (t, 3).

    An accelerometer measures this acceleration minus gravity, in its own axes. If the base of the machine
    accelerates (`BaseAcceleration`), the acceleration is absolute, but positions and velocities are relative
    to the base.
    """

    quantity = QuantityKind.ACCELERATION

    def values(self, system: System, solution: Solution) -> FloatArray:
        """d2r/dt2 (t, 3)."""
        seen_from_base = self.place.motion(system, solution, self.name).acceleration
        if np.isnan(seen_from_base).all():
            raise ModelError(
                f"sensor '{self.name}': the motion of body '{self.place.body}' has no accelerations: it was "
                "recorded by an earlier version; run the case again"
            )
        return seen_from_base + base_acceleration(system, solution.times)


def base_acceleration(system: System, times: FloatArray) -> FloatArray:
    """Absolute acceleration (t, 3) of the base of a machine at given times, global components."""
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
        if self.at != GROUND:
            body_named(system, self.at.body, self.name).interface(self.at.interface)
        return vector_channels("global", {"": QuantityKind.ANGULAR_VELOCITY})

    def values(self, system: System, solution: Solution) -> FloatArray:
        """W (t, 3)."""
        if self.at == GROUND:
            return np.zeros((len(solution.times), 3))
        body = body_named(system, self.at.body, self.name)
        return body.interface_motion(solution.bodies[self.at.body], self.at.interface).angular_velocity


@dataclass(frozen=True)
class DeflectionSensor(_AtPlace):
    """Displacement of a place relative to an interface, in the mesh axes that rotate with it, (t, 3).

    seen_from : At | None   the interface, of this or another body; by default the first interface of the
        body of the place; required for a place of explicit elements
    """

    seen_from: At | None = None

    quantity = QuantityKind.LENGTH

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.seen_from is not None:
            object.__setattr__(self, "seen_from", as_end(self.seen_from))

    def channels(self, system: System) -> Sequence[Channel]:
        """x, y, z."""
        body, base = self.place.body_of(system, self.name), self.base(system)
        if base is not None:
            body_named(system, base.body, self.name).interface(base.interface)
        elif not body.has_frame:
            raise ModelError(
                f"sensor '{self.name}': body '{body.name}' has explicit finite elements, and no first "
                "interface as reference of its deflection: give seen_from, an interface of another body "
                "(in Python also one of its node sets), or use a position sensor"
            )
        seen_from = base or f"the frame of {body.name}"
        return vector_channels(f"mesh axes turning with {seen_from}", {"": self.quantity})

    def values(self, system: System, solution: Solution) -> FloatArray:
        """`A_p^T (r - r_p) - (x - x_p)`, (t, 3): r of the place, r_p of the interface; x, x_p undeformed."""
        self.channels(system)
        body, base = body_named(system, self.place.body, self.name), self.base(system)
        seen = observer_of(system, solution, self.place.body, {} if base is None else {self.place.body: base})
        return tracked_motion(body, solution.bodies[self.place.body], self.place.at, seen).deflection

    def base(self, system: System) -> At | None:
        """The reference interface of the deflection; by default that of `observer_of`, None for a frame."""
        if self.seen_from is not None:
            return self.seen_from
        body = body_named(system, self.place.body, self.name)
        has_first = body.has_frame and body.interfaces
        return At(self.place.body, body.interfaces[0].name) if has_first else None
