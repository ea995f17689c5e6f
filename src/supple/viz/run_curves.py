"""Curves of a run over time: sensors, energies, tracked places, forces of joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.integrate import Solution
from supple.machine import System
from supple.methods.explicit import ENERGIES, Energies
from supple.quantities import QuantityKind, Reading, TrackedMotion, joint_loads
from supple.results import without_noise
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.style import as_written
from supple.viz.time_history import NOISE, Panel, Series, plot_time_history

_APART = 5.0
"""Places share a panel if their common range is at most this multiple of the largest range of one place."""


@checked_arguments
def plot_readings(path: Path | str, readings: Sequence[Reading], *, units: UnitSystem = UNNAMED) -> Path:
    """Draw the channels of every sensor over time, one panel for each quantity of a sensor.

    Raises
    ------
    ModelError          no reading
    ResultFileError     the file cannot be written
    """
    panels = []
    for each in readings:
        for quantity in dict.fromkeys(channel.quantity for channel in each.channels):
            panels.append(Panel(labelled(each.name, quantity.unit(units)), _curves(each, quantity)))
    return plot_time_history(path, panels, units=units)


def _curves(reading: Reading, quantity: QuantityKind) -> list[Series]:
    columns = zip(reading.channels, reading.values.T, strict=True)
    return [
        Series(channel.name or reading.name, reading.times, column)
        for channel, column in columns
        if channel.quantity is quantity
    ]


def draw_energies(path: Path, solution: Solution, units: UnitSystem) -> Path:
    """Plot of every term of the energy balance that is not round-off."""
    energies = without_noise(solution.series[ENERGIES]).T
    shown = [
        Series(name, solution.times, values)
        for name, values in zip(Energies._fields, energies, strict=True)
        if values.any() or name == "kinetic"
    ]
    return plot_time_history(path, [Panel(labelled("energy", units.energy), shown)], units=units)


def draw_tracked(
    path: Path, tracked: Mapping[str, TrackedMotion], times: FloatArray, units: UnitSystem
) -> Path:
    """Plot of the motion of every place in global axes, and beside it the deflection of elastic places.

    Places that are far apart are drawn in separate panels.
    """
    elastic = {
        name: without_noise(place.deflection, like=place.position)
        for name, place in tracked.items()
        if place.is_elastic
    }
    moved = max((float(np.abs(each).max()) for each in elastic.values()), default=0.0)
    reach = max(float(np.abs(place.position).max()) for place in tracked.values())
    panels: list[Panel | None] = []
    for i, axis in enumerate("xyz"):
        for names in _near({name: place.position[:, i] for name, place in tracked.items()}, reach):
            label = labelled(f"{axis}, global", units.length)
            places = [Series(as_written(name), times, tracked[name].position[:, i]) for name in names]
            panels.append(Panel(label, places, reach))
            bent = [Series(as_written(name), times, elastic[name][:, i]) for name in names if name in elastic]
            label = labelled(f"deflection {axis}", units.length)
            panels += [Panel(label, bent, moved) if bent else None] if elastic else []
    return plot_time_history(path, panels, n_columns=2 if elastic else 1, units=units)


def _near(ways: Mapping[str, FloatArray], reach: float) -> Iterator[Sequence[str]]:
    """Groups of places that share a panel: the range of a group is not much larger than that of one place.

    ways : positions (t,) of each place along an axis;  reach : the largest position along any axis
    """
    lows, highs = ({name: float(pick(way)) for name, way in ways.items()} for pick in (np.min, np.max))
    order = list(ways)
    group: list[str] = []
    for name in sorted(ways, key=lambda each: lows[each]):
        together = [*group, name]
        widest = max(highs[each] - lows[each] for each in together)
        across = max(highs[each] for each in together) - lows[together[0]]
        # Places that do not move share a panel at any distance: there is no motion to hide.
        if group and widest > NOISE * reach and across > _APART * widest:
            yield sorted(group, key=order.index)
            together = [name]
        group = together
    yield sorted(group, key=order.index)


def draw_joint_forces(path: Path, system: System, solution: Solution, units: UnitSystem) -> Path | None:
    """Plot of the loads on the second ends: rows x, y, z of the joint axes, columns force and moment.

    None if no joint transmits a load.
    """
    loads = joint_loads(system, solution)
    columns = [
        (what, unit)
        for what, unit in (("force", units.force), ("moment", units.moment))
        if any(what in parts for parts in loads.values())
    ]
    if not columns:
        return None
    largest = {
        what: max(float(np.abs(parts[what]).max()) for parts in loads.values() if what in parts)
        for what, _ in columns
    }
    panels = []
    for i, axis in enumerate("xyz"):
        for what, unit in columns:
            curves = [
                Series(as_written(f"{joint.name} on {joint.second}"), solution.times, parts[what][:, i])
                for joint in system.joints
                if what in (parts := loads[joint.name])
            ]
            panels.append(Panel(labelled(f"{what}, joint {axis}", unit), curves, largest[what]))
    return plot_time_history(path, panels, n_columns=len(columns), units=units)
