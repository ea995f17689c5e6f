"""Outputs of a step program: sensors and closed contacts as functions of a state that JAX can trace."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.build_model import force_group_of, readers_of
from supple.equations.configuration import SystemMotion
from supple.equations.ends import markers
from supple.equations.joint_force import all_multipliers
from supple.equations.joint_linearization import affine_form, axial
from supple.equations.machine_model import STATIC, Ends, ForceGroup, Model
from supple.equations.marker import pose
from supple.equations.places import member
from supple.machine import GROUND, EndReading, ForceElement, JointFriction, JointReading, System
from supple.machine.forces.relative_motion import axial_motion, wrapped
from supple.machine.pose import Pose
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
from supple.stepping.sensed_machine import SensedMachine
from supple.stepping.variables import Variable
from supple.units import UnitSystem

Reads = Callable[[Model, SystemMotion, AnyArray, AnyArray], AnyArray]
"""Function (model, motion, previous channels (c,), time since the previous channels) -> channels (c,)."""


@dataclass(frozen=True)
class SensedOutputs:
    """The channels of some sensors, concatenated."""

    variables: tuple[Variable, ...]
    reads: tuple[tuple[int, Reads], ...]
    """For each sensor, the number of channels and the function that computes them"""
    left_out: tuple[str, ...]
    """Names of sensors that JAX cannot trace"""

    def at(self, model: Model, motion: SystemMotion, before: AnyArray, elapsed: AnyArray) -> AnyArray:
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
        made = next((make for kind, make in _READS.items() if isinstance(sensor, kind)), None)
        read = None if made is None else made(seen, sensor)
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

    def at(self, model: Model, motion: SystemMotion) -> tuple[AnyArray, AnyArray, AnyArray]:
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


def _of_point(
    derivative: int, seen: SensedMachine, sensor: PositionSensor | VelocitySensor | AccelerationSensor
) -> Reads | None:
    """Position, velocity or acceleration in space of a place, by the number of the derivative."""
    place = seen.place(sensor.place)
    if place is None:
        return None
    point = _Point.of(seen.system, place)

    def read(model: Model, motion: SystemMotion, *_: AnyArray) -> AnyArray:
        value = point.at(model, motion)[derivative]
        if derivative < 2:
            return value
        return value + sum(jnp.asarray(law(motion.time), dtype=float) for law in model.base_accelerations)

    return read


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

    def read(model: Model, motion: SystemMotion, *_: AnyArray) -> AnyArray:
        from_there = _pose_of(reader.first, motion)
        axes = from_there.axes @ to_mesh
        return axes.T @ (point.at(model, motion)[0] - from_there.point) - rest

    return read


def _angular_velocity(seen: SensedMachine, sensor: AngularVelocitySensor) -> Reads:
    if sensor.at == GROUND:
        return lambda *_: jnp.zeros(3)
    (reader,) = readers_of(seen.system, {"end": EndReading(seen.end(sensor.at))})
    return lambda _, motion, *__: _pose_of(reader.first, motion).angular_velocity


def _joint_motion(seen: SensedMachine, sensor: JointMotionSensor) -> Reads:
    (reader,) = readers_of(seen.system, {"joint": JointReading(sensor.joint)})

    def read(_model: Model, motion: SystemMotion, before: AnyArray, elapsed: AnyArray) -> AnyArray:
        own = axial_motion(_pose_of(reader.first, motion), _pose_of(reader.second, motion))
        # As in the sensor: the angle within half a revolution of the value predicted by the mean rate.
        expected = before[0] + elapsed * (before[1] + own.rate) / 2
        angle = expected + wrapped(own.angle - expected)
        return jnp.stack([angle, own.rate, own.slide, own.speed])

    return read


def _joint_wrench(system: System, name: str) -> Reads:
    """Force and moment (6,) on the second end of a joint, in axes of the first end."""
    joint = next(each for each in system.joints if each.name == name)
    rows = system.constraint_slices[name]
    (reader,) = readers_of(system, {"joint": JointReading(name)})

    def read(model: Model, motion: SystemMotion, *_: AnyArray) -> AnyArray:
        group = next(each for each in model.joints if rows.start in each.rows.starts)
        value = None
        if group.law is not None:
            number = group.rows.starts.index(rows.start)
            value = jnp.asarray(member(group.law, number)(motion.time))
        coefficients = jnp.asarray(affine_form(type(joint).constraint, value)[0])
        weights = all_multipliers(model, jnp.asarray(motion.multipliers))[rows] @ coefficients
        turn = _pose_of(reader.first, motion).axes.T @ _pose_of(reader.second, motion).axes
        return -jnp.concatenate([weights[:3], axial(weights[3:].reshape(3, 3) @ turn.T)])

    return read


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

    def read(group: ForceGroup, model: Model, motion: SystemMotion, *_: AnyArray) -> AnyArray:
        first, second = _pose_of(group.first, motion), _pose_of(group.second, motion)
        parameters = member(group.parameters)
        value: AnyArray = None if carried is None else carried(model, motion, *_)[:2]
        if group.law is not None:
            value = jnp.asarray(member(group.law)(motion.time))
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
    PositionSensor: partial(_of_point, 0),
    VelocitySensor: partial(_of_point, 1),
    AccelerationSensor: partial(_of_point, 2),
    DeflectionSensor: _deflection,
    AngularVelocitySensor: _angular_velocity,
    JointMotionSensor: _joint_motion,
    JointForceSensor: lambda seen, sensor: _joint_wrench(seen.system, sensor.joint),
    SpringForceSensor: _element,
    ElementEnergySensor: _element,
}
"""Functions that build the `Reads` of a sensor, by the type of the sensor; None if JAX cannot trace it."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Contacts:
    """The force elements of a machine that act by a penalty, each as a group of one element."""

    kinds: tuple[type[ForceElement], ...] = field(metadata=STATIC)
    groups: tuple[ForceGroup, ...]

    def at(self, motion: SystemMotion) -> AnyArray:
        """Whether each element (c,) is closed: its penalty stores energy."""
        no_law: AnyArray = None
        flags = []
        for kind, group in zip(self.kinds, self.groups, strict=True):
            ends = _pose_of(group.first, motion), _pose_of(group.second, motion)
            flags.append(kind.energy(*ends, no_law, member(group.parameters)) > 0)
        return jnp.stack(flags) if flags else jnp.zeros(0, dtype=bool)


def contacts_of(system: System) -> Contacts:
    """The stops and contacts of a machine, in the order of its loads."""
    elements = [each for each in system.loads if isinstance(each, ForceElement) and hasattr(each, "penalty")]
    groups = tuple(force_group_of(system, each) for each in elements)
    return Contacts(tuple(type(each) for each in elements), groups)


def _pose_of(ends: Ends, motion: SystemMotion) -> Pose:
    """Position, axes and velocities of the first of some ends."""
    return pose(member(markers(ends, motion.configuration, motion.velocity)))
