"""Plots of sensor readings over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from supple.arguments import checked_arguments
from supple.quantities import QuantityKind, Reading
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.time_history import Panel, Series, plot_time_history

__all__ = ["plot_readings"]


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
