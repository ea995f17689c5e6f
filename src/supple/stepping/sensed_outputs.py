"""Outputs of a step program: sensors as functions of a state that JAX can trace."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.build_model import force_group_of, readers_of
from supple.equations.configuration import SystemMotion
from supple.equations.joint_linearization import affine_form, axial
from supple.equations.machine_model import Model
from supple.machine import GROUND, EndReading, JointFriction, JointReading, System
from supple.machine.forces.relative_motion import axial_motion, wrapped
from supple.quantities import (
    AccelerationSensor,
    AngularVelocitySensor,
    DeflectionSensor,
    ElementEnergySensor,
    JointForceSensor,
    JointMotionSensor,
    Place,
    PositionSensor,
    Quantity,
    SpringForceSensor,
    VelocitySensor,
)
from supple.stepping.one_of_group import one_of, pose_of
from supple.stepping.sensed_machine import SensedMachine
from supple.stepping.variables import Variable
from supple.units import UnitSystem

__all__ = ["SensedOutputs", "sensed_outputs"]

Reads = Callable[[Model, SystemMotion, Any, Any], Any]
"""Function (model, motion, previous channels (c,), time since the previous channels) -> channels (c,)."""


@dataclass(frozen=True)
class SensedOutputs:
    """The channels of some sensors, concatenated."""

    variables: tuple[Variable, ...]
    reads: tuple[tuple[int, Reads], ...]
    """For each sensor, the number of channels and the function that computes them"""
    left_out: tuple[str, ...]
    """Names of sensors that JAX cannot trace"""

    def at(self, model: Model, motion: SystemMotion, before: Any, elapsed: Any) -> Any:
        """Channels (k,) for a motion.

        before : (k,) channels at a time earlier by `elapsed`, from which angles are continued
        """
        parts, first = [jnp.zeros(0)], 0
        for size, read in self.reads:
            parts.append(read(model, motion, before[first : first + size], elapsed))
            first += size
        return jnp.concatenate(parts)


def sensed_outputs(seen: SensedMachine, sensors: Sequence[Quantity], units: UnitSystem) -> SensedOutputs:
    """The channels of sensors as functions of a motion; sensors that JAX cannot trace are left out."""
    variables, reads, left_out = [], [], []
    for sensor in sensors:
        read = _read_of(seen, sensor)
        if read is None:
            left_out.append(sensor.name)
            continue
        channels = sensor.channels(seen.own)
        variables += [
            Variable(
                f"{sensor.name}.{channel.name}" if channel.name else sensor.name,
                channel.quantity.unit(units),
                channel.quantity.value + (f", {channel.axes}" if channel.axes else ""),
            )
            for channel in channels
        ]
        reads.append((len(channels), read))
    return SensedOutputs(tuple(variables), tuple(reads), tuple(left_out))


def _read_of(seen: SensedMachine, sensor: Quantity) -> Reads | None:
    made = next((make for kind, make in _READS.items() if isinstance(sensor, kind)), None)
    return None if made is None else made(seen, sensor)


def _position(seen: SensedMachine, sensor: PositionSensor) -> Reads | None:
    return _of_point(seen, sensor.place, lambda moving, *_: moving[0])


def _velocity(seen: SensedMachine, sensor: VelocitySensor) -> Reads | None:
    return _of_point(seen, sensor.place, lambda moving, *_: moving[1])


def _acceleration(seen: SensedMachine, sensor: AccelerationSensor) -> Reads | None:
    return _of_point(seen, sensor.place, _absolute)


def _absolute(moving: Any, time: Any, model: Model) -> Any:
    return moving[2] + sum(jnp.asarray(law(time), dtype=float) for law in model.base_accelerations)


@dataclass(frozen=True)
class _Point:
    """A point of a body, `r = R + A (x + U q + q^T H q)`, with the frame's origin R and axes A.

    rest : x, position of the undeformed point in the body's frame;   q : deformation coordinates
    """

    body: int
    rest: np.ndarray
    linear: np.ndarray
    """U, (3, r)"""
    quadratic: np.ndarray
    """H, (3, r, r), symmetric"""

    @classmethod
    def of(cls, system: System, place: Place) -> _Point:
        """The point at a place of a body."""
        index = system.body_index(place.body)
        body: Any = system.bodies[index].body
        r = body.n_coordinates
        if isinstance(place.at, str):
            interface = body.interface(place.at)
            motion = interface.motion
            dense = motion.toarray() if hasattr(motion, "toarray") else np.asarray(motion)
            return cls(index, np.asarray(interface.position), dense[:3], np.zeros((3, r, r)))
        rest = np.asarray(place.rest(body))
        if not r:
            return cls(index, rest, np.zeros((3, 0)), np.zeros((3, 0, 0)))

        def moved(coordinates: np.ndarray) -> np.ndarray:
            return body.expand(coordinates, np.array(place.at)).mean(axis=1)

        unit = np.eye(r)
        first, second = np.triu_indices(r)
        by_one, back = moved(unit), moved(-unit)
        linear, own = (by_one - back) / 2, (by_one + back) / 2
        pairs = moved(unit[first] + unit[second]) - linear[first] - linear[second]
        quadratic = np.zeros((r, r, 3))
        quadratic[first, second] = (pairs - own[first] - own[second]) / 2
        quadratic[second, first] = quadratic[first, second]
        rounding = 1e-9 * np.abs(linear).max(initial=0.0)
        quadratic[np.abs(quadratic) <= rounding] = 0.0
        return cls(index, rest, linear.T, np.moveaxis(quadratic, 2, 0))

    def at(self, model: Model, motion: SystemMotion) -> tuple[Any, Any, Any]:
        """Position, velocity and acceleration (3,), global."""
        configuration, own = motion.configuration, model.slices[self.body]
        origin, turn = configuration.origins[self.body], configuration.rotations[self.body]
        q = configuration.coordinates[model.coordinate_slices[self.body]]
        v, a = motion.velocity[own], motion.acceleration[own]
        w, dq, ddq = v[3:6], v[6:], a[6:]
        by_q = self.linear + 2 * self.quadratic @ q if self.quadratic.any() else self.linear
        arm = self.rest + (self.linear + by_q) @ q / 2
        rate, second = by_q @ dq, by_q @ ddq
        if self.quadratic.any():
            second = second + 2 * self.quadratic @ dq @ dq
        velocity = v[:3] + turn @ (jnp.cross(w, arm) + rate)
        seen = jnp.cross(a[3:6], arm) + jnp.cross(w, jnp.cross(w, arm) + 2 * rate) + second
        return origin + turn @ arm, velocity, a[:3] + turn @ seen


def _of_point(seen: SensedMachine, place: Place, chosen: Callable[..., Any]) -> Reads | None:
    own = seen.place(place)
    if own is None:
        return None
    point = _Point.of(seen.system, own)
    return lambda model, motion, *_: chosen(point.at(model, motion), motion.time, model)


def _deflection(seen: SensedMachine, sensor: DeflectionSensor) -> Reads | None:
    base, place = sensor.base(seen.own), seen.place(sensor.place)
    if base is None or place is None:
        return None
    point, end = _Point.of(seen.system, place), seen.end(base)
    (reader,) = readers_of(seen.system, {"seen from": EndReading(end)})
    own = seen.own.placed(sensor.place.body)
    position, to_mesh = own.assembly
    start = to_mesh.T @ (seen.own.initial_point(base) - position)
    rest = np.asarray(sensor.place.rest(own.body)) - start
    # A reader uses the global axes at assembly, a deflection the axes of the mesh of the place.

    def read(model: Model, motion: SystemMotion, *_: Any) -> Any:
        from_there = pose_of(reader.first, motion)
        axes = from_there.axes @ to_mesh
        return axes.T @ (point.at(model, motion)[0] - from_there.point) - rest

    return read


def _angular_velocity(seen: SensedMachine, sensor: AngularVelocitySensor) -> Reads:
    if sensor.at == GROUND:
        return lambda *_: jnp.zeros(3)
    (reader,) = readers_of(seen.system, {"end": EndReading(seen.end(sensor.at))})
    return lambda _, motion, *__: pose_of(reader.first, motion).angular_velocity


def _joint_motion(seen: SensedMachine, sensor: JointMotionSensor) -> Reads:
    (reader,) = readers_of(seen.system, {"joint": JointReading(sensor.joint)})

    def read(_model: Model, motion: SystemMotion, before: Any, elapsed: Any) -> Any:
        own = axial_motion(pose_of(reader.first, motion), pose_of(reader.second, motion))
        # As in the sensor: the angle within half a revolution of the value predicted by the mean rate.
        expected = before[0] + elapsed * (before[1] + own.rate) / 2
        angle = expected + wrapped(own.angle - expected)
        return jnp.stack([angle, own.rate, own.slide, own.speed])

    return read


def _joint_wrench(system: System, name: str) -> Callable[[Model, SystemMotion], Any]:
    """Function (model, motion) -> force and moment (6,) on the second end, in axes of the first end."""
    joint = next(each for each in system.joints if each.name == name)
    rows = system.constraint_slices[name]
    (reader,) = readers_of(system, {"joint": JointReading(name)})

    def read(model: Model, motion: SystemMotion) -> Any:
        group = next(each for each in model.joints if rows.start in each.rows.starts)
        value = None
        if group.law is not None:
            number = group.rows.starts.index(rows.start)
            value = jnp.asarray(one_of(group.law, number)(motion.time))
        coefficients = jnp.asarray(affine_form(type(joint).constraint, value)[0])
        every = jnp.zeros(model.n_equations).at[np.array(model.active, dtype=int)].set(motion.multipliers)
        weights = every[rows] @ coefficients
        turn = pose_of(reader.first, motion).axes.T @ pose_of(reader.second, motion).axes
        return -jnp.concatenate([weights[:3], axial(weights[3:].reshape(3, 3) @ turn.T)])

    return read


def _joint_force(seen: SensedMachine, sensor: JointForceSensor) -> Reads:
    wrench = _joint_wrench(seen.system, sensor.joint)
    return lambda model, motion, *_: wrench(model, motion)


class _Unnamed:
    """A function that compares equal to every other one of this type.

    Its variable data are leaves of the enclosing pytree, so that pytrees of machine variants have equal
    structures.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function

    def __call__(self, *arguments: Any) -> Any:
        return self.function(*arguments)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Unnamed)

    def __hash__(self) -> int:
        return 0


def _element(seen: SensedMachine, sensor: SpringForceSensor | ElementEnergySensor) -> Reads | None:
    system, element = seen.system, seen.element(sensor.element)
    if element.law is not None and not any(each is element for each in system.loads):
        return None  # a controller adds to its law
    group = force_group_of(system, element)
    carried = _joint_wrench(system, element.joint.name) if isinstance(element, JointFriction) else None
    kind, energy = type(element), isinstance(sensor, ElementEnergySensor)

    def read(group: Any, model: Model, motion: SystemMotion, *_: Any) -> Any:
        first, second = pose_of(group.first, motion), pose_of(group.second, motion)
        parameters = one_of(group.parameters, 0)
        value: Any = None if carried is None else carried(model, motion)[:2]
        if group.law is not None:
            value = jnp.asarray(one_of(group.law, 0)(motion.time))
        loads = kind.wrenches(first, second, value, parameters)
        if not energy:
            return jnp.concatenate(loads[0 if kind.acts_on_first_alone else 1])
        stored = jnp.asarray(kind.energy(first, second, value, parameters), dtype=float)
        power = sum(
            load.force @ end.velocity + load.moment @ end.angular_velocity
            for load, end in zip(loads, (first, second), strict=True)
        )
        return jnp.stack([stored, power])

    return jax.tree_util.Partial(_Unnamed(read), group)


_READS: dict[type, Callable[[SensedMachine, Any], Reads | None]] = {
    PositionSensor: _position,
    VelocitySensor: _velocity,
    AccelerationSensor: _acceleration,
    DeflectionSensor: _deflection,
    AngularVelocitySensor: _angular_velocity,
    JointMotionSensor: _joint_motion,
    JointForceSensor: _joint_force,
    SpringForceSensor: _element,
    ElementEnergySensor: _element,
}
"""Functions that build the `Reads` of a sensor, by the type of the sensor; None if JAX cannot trace it."""
