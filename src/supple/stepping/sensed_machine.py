"""A machine for evaluating its sensors, in which stations of intrinsic bodies are separate bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from supple.machine import GROUND, At, ForceElement, System
from supple.methods.intrinsic.joined_machine import seen_element, seen_end
from supple.quantities import (
    AngularVelocitySensor,
    DeflectionSensor,
    ElementEnergySensor,
    Place,
    Quantity,
    SpringForceSensor,
)


@dataclass(frozen=True, eq=False)
class SensedMachine:
    """A machine, and the system of its model, in which stations replace intrinsic bodies.

    own : the machine that the sensors refer to
    system : the system of the model, with the names and the order of the machine's joints and elements; it is
        `own` if all bodies are rigid or reduced
    """

    own: System
    system: System

    def end(self, end: At) -> At:
        """The end in the system of the model."""
        return end if self.own is self.system else seen_end(self.own, end)

    def place(self, place: Place) -> Place | None:
        """The place in the system of the model; None for nodes of an intrinsic body."""
        if isinstance(place.at, str):
            end = self.end(At(place.body, place.at))
            return Place(end.body, end.interface)
        return None if _is_line(self.own, place.body) else place

    def element(self, element: ForceElement) -> ForceElement:
        """The force element in the system of the model; it need not be an element of the machine."""
        if self.own is self.system:
            return element
        pairs = zip(_elements(self.own), _elements(self.system), strict=True)
        return next((seen for own, seen in pairs if own is element), seen_element(self.own, element))


def ends_on_lines(system: System, sensors: Sequence[Quantity]) -> list[At]:
    """Ends on intrinsic bodies that sensors use."""
    ends: list[At | None] = []
    for sensor in sensors:
        place = getattr(sensor, "place", None)
        if isinstance(place, Place) and isinstance(place.at, str):
            ends.append(At(place.body, place.at))
        if isinstance(sensor, DeflectionSensor):
            ends.append(sensor.base(system))
        if isinstance(sensor, AngularVelocitySensor):
            ends.append(sensor.at)
        if isinstance(sensor, SpringForceSensor | ElementEnergySensor):
            ends += [sensor.element.first, sensor.element.second]
    return [end for end in ends if end is not None and end != GROUND and _is_line(system, end.body)]


def _elements(system: System) -> list[ForceElement]:
    return [load for load in system.loads if isinstance(load, ForceElement)]


def _is_line(system: System, body: str) -> bool:
    return system.placed(body).body.kind == "intrinsic"
