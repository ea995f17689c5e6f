"""Curves of a run: sensors, tracked places, joints, contacts, energies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.integrate import JOINT_AXES, Solution
from supple.machine import System
from supple.methods.explicit import ENERGIES, Energies
from supple.quantities import Reading, TrackedMotion, contact_forces, joint_loads
from supple.results import without_noise
from supple.units import UNNAMED, UnitSystem, labelled


@dataclass(frozen=True, eq=False)
class Chart:
    """Curves over one abscissa (n,), which is the time of a run unless it has a label.

    label : of the ordinate, with its unit;   curves : (n,) by name;   note : such as the axes, or ""
    """

    title: str
    label: str
    abscissa: FloatArray
    curves: Mapping[str, FloatArray]
    note: str = ""
    abscissa_label: str = ""


def charts_of(
    system: System,
    solution: Solution,
    *,
    tracked: Mapping[str, TrackedMotion],
    readings: Sequence[Reading],
    units: UnitSystem = UNNAMED,
) -> Iterator[Chart]:
    """Charts of sensors, deflection and position of tracked places, joint and contact forces, energies."""
    times = solution.times
    for reading in readings:
        yield from _charts_of_reading(reading, units)
    for name, place in tracked.items():
        if place.is_elastic:
            bent = without_noise(place.deflection, like=place.position)
            note = f"seen from {place.seen_from or 'its frame'}, in axes that rotate with it"
            yield Chart(f"{name}, deflection", labelled("deflection", units.length), times, _xyz(bent), note)
        position = _xyz(without_noise(place.position))
        yield Chart(f"{name}, position", labelled("position", units.length), times, position, "global axes")
    loads = joint_loads(system, solution)
    for what, unit in (("force", units.force), ("moment", units.moment)):
        like = np.concatenate([np.zeros((1, 3)), *(own[what] for own in loads.values() if what in own)])
        for joint in system.joints:
            if what in loads[joint.name]:
                values = _xyz(without_noise(loads[joint.name][what], like=like))
                note = f"on {joint.second}, {JOINT_AXES}"
                yield Chart(f"{joint.name}, {what}", labelled(what, unit), times, values, note)
    contacts = contact_forces(system, solution)
    like = np.concatenate([np.zeros((1, 3)), *(contact.force for contact in contacts)])
    for contact in contacts:
        values = _xyz(without_noise(contact.force, like=like))
        label = labelled("force", units.force)
        yield Chart(f"{contact.name}, force", label, times, values, "on the contact's nodes, global axes")
    if ENERGIES in solution.series:
        energies = without_noise(solution.series[ENERGIES]).T
        terms = zip(Energies._fields, energies, strict=True)
        curves = {name: values for name, values in terms if values.any() or name == "kinetic"}
        yield Chart("energies", labelled("energy", units.energy), times, curves)


def _charts_of_reading(reading: Reading, units: UnitSystem) -> Iterator[Chart]:
    """A chart for each quantity of a sensor."""
    for quantity in dict.fromkeys(channel.quantity for channel in reading.channels):
        own = [number for number, each in enumerate(reading.channels) if each.quantity == quantity]
        values = without_noise(reading.values[:, own])
        channels = [reading.channels[number] for number in own]
        curves = {each.name or reading.name: column for each, column in zip(channels, values.T, strict=True)}
        words = {word for each in channels for word in (each.axes, each.place) if word}
        yield Chart(
            f"{reading.name}, {quantity.value}",
            labelled(quantity.value, quantity.unit(units)),
            reading.times,
            curves,
            ", ".join(sorted(words)),
        )


def _xyz(values: FloatArray) -> dict[str, FloatArray]:
    return dict(zip("xyz", values.T, strict=True))
