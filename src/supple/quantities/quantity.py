"""A quantity of the motion of a machine: a name, channels with unit and axes, and values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.integrate import Solution
from supple.integrate.solution import concatenate
from supple.machine import System
from supple.quantities.reading import Channel, Located, QuantityKind, Reading, Readings

__all__ = ["Channel", "LocatedQuantity", "Quantity", "QuantityKind", "read_in_parts", "read_sensors"]


class Quantity(Protocol):
    """Channels computed from the motion of a machine, such as those of a sensor."""

    @property
    def name(self) -> str:
        """Name in tables and files; unique among the sensors of a run."""
        ...

    def channels(self, system: System, /) -> Sequence[Channel]:
        """The channels of the quantity, one per column of its values.

        Raises ModelError for a place, joint or force that the machine does not have.
        """
        ...

    def values(self, system: System, solution: Solution, /) -> FloatArray:
        """Values (t, c) at the output times, in the units of the model."""
        ...


@runtime_checkable
class LocatedQuantity(Quantity, Protocol):
    """A quantity for which the node of each value is known."""

    def located(self, system: System, solution: Solution, /) -> Located:
        """The values of the quantity, with their nodes."""
        ...


@checked_arguments
def read_sensors(sensors: Sequence[Quantity], system: System, solution: Solution) -> Readings:
    """The readings of sensors over a run.

    Raises
    ------
    ModelError  two sensors of the same name; a place, joint, force or body that the machine does not have; a
                quantity that the form of the body does not have
    """
    names = [sensor.name for sensor in sensors]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(f"sensor name '{name}' is used {names.count(name)} times: names must differ")
    return Readings(_reading(sensor, system, solution) for sensor in sensors)


@checked_arguments
def read_in_parts(sensors: Sequence[Quantity], system: System, parts: Iterable[Solution]) -> Readings:
    """The readings of sensors over a run that is given in parts, such as `ResultParts`.

    Revolutions of angles are counted across parts. Raises the errors of `read_sensors`, and ModelError if
    there is no part.
    """
    found: list[Readings] = []
    last: Solution | None = None
    for part in parts:
        # The last time of the previous part is repeated, so that angles continue from it.
        begun = part if last is None else concatenate([last, part])
        readings = read_sensors(sensors, system, begun)
        found.append(readings if last is None else _continued(found[-1], readings))
        last = part.at(slice(-1, None))
    if not found:
        raise ModelError("there is no output time to read: give at least one part of a run")
    return Readings(_one_after_another(own) for own in zip(*found, strict=True))


def _continued(before: Readings, readings: Readings) -> Readings:
    """The readings without their first time, the last time of `before`; angles continue from `before`."""

    def continued(old: Reading, new: Reading) -> Reading:
        is_angle = np.array([each.quantity is QuantityKind.ANGLE for each in new.channels])
        turns = np.round((old.values[-1] - new.values[0]) / (2 * np.pi))
        values = new.values[1:] + np.where(is_angle, 2 * np.pi * turns, 0.0)
        return replace(
            new,
            times=new.times[1:],
            values=values,
            nodes=None if new.nodes is None else new.nodes[1:],
            points=None if new.points is None else new.points[1:],
        )

    return Readings(continued(old, new) for old, new in zip(before, readings, strict=True))


def _one_after_another(parts: Sequence[Reading]) -> Reading:
    first = parts[0]
    nodes, points = (
        None if getattr(first, name) is None else np.concatenate([getattr(each, name) for each in parts])
        for name in ("nodes", "points")
    )
    times, values = (np.concatenate([getattr(each, name) for each in parts]) for name in ("times", "values"))
    return Reading(first.name, first.channels, times, values, nodes, points)


def _reading(sensor: Quantity, system: System, solution: Solution) -> Reading:
    channels = tuple(sensor.channels(system))
    if isinstance(sensor, LocatedQuantity):
        found = sensor.located(system, solution)
    else:
        found = Located(sensor.values(system, solution))
    return Reading(sensor.name, channels, np.asarray(solution.times), *found)
