"""What is read off the motion of a machine: a name, channels with unit and axes, and values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.errors import ModelError
from supple.integrate import Solution
from supple.machine import System
from supple.quantities.reading import Channel, Located, QuantityKind, Reading
from supple.quantities.readings import Readings

__all__ = ["Channel", "LocatedQuantity", "Quantity", "QuantityKind", "read_sensors"]

Array = NDArray[np.float64]


class Quantity(Protocol):
    """Channels that are read off the motion of a machine; a sensor is one."""

    @property
    def name(self) -> str:
        """In tables and files; unique among the sensors of a run."""
        ...

    def channels(self, system: System, /) -> Sequence[Channel]:
        """What it measures, one entry per column of its values.

        Raises ModelError for a place, joint or force that the machine does not have.
        """
        ...

    def values(self, system: System, solution: Solution, /) -> Array:
        """(t, c) at the output times, in the units of the model."""
        ...


@runtime_checkable
class LocatedQuantity(Quantity, Protocol):
    """A quantity whose nodes are known."""

    def located(self, system: System, solution: Solution, /) -> Located:
        """Its values, with the nodes."""
        ...


def vector_channels(quantity: QuantityKind, axes: str) -> tuple[Channel, ...]:
    """Of three components along x, y and z."""
    return tuple(Channel(name, quantity, axes) for name in "xyz")


@checked_arguments
def read_sensors(sensors: Sequence[Quantity], system: System, solution: Solution) -> Readings:
    """The readings of some sensors over a run.

    Raises
    ------
    ModelError  two sensors of one name; a place, joint, force or body that the machine does not have; a
                quantity that the form of the body does not have
    """
    names = [sensor.name for sensor in sensors]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(f"sensor name '{name}' is used {names.count(name)} times: names must differ")
    return Readings(_reading(sensor, system, solution) for sensor in sensors)


def _reading(sensor: Quantity, system: System, solution: Solution) -> Reading:
    channels = tuple(sensor.channels(system))
    if isinstance(sensor, LocatedQuantity):
        found = sensor.located(system, solution)
    else:
        found = Located(sensor.values(system, solution))
    return Reading(sensor.name, channels, np.asarray(solution.times), *found)
