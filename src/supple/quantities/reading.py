"""Readings of sensors: channels over time, and the files that hold them."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray

from supple.algebra import read_only
from supple.arguments import checked_arguments
from supple.errors import ModelError
from supple.storage.atomic_write import replacing
from supple.units import UNNAMED, UnitSystem, labelled

__all__ = ["Located", "Reading", "as_dataset", "write_readings", "write_readings_hdf5"]

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


class QuantityKind(Enum):
    """The kind of quantity that a channel measures; its unit follows from those of the model."""

    LENGTH = "length"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    ANGLE = "angle"
    ANGULAR_VELOCITY = "angular velocity"
    FORCE = "force"
    MOMENT = "moment"
    STRESS = "stress"
    STRAIN = "strain"
    ENERGY = "energy"
    POWER = "power"

    def unit(self, units: UnitSystem) -> str:
        """The name of its unit, "" where nothing is said of it; angles are in rad, strains are numbers."""
        known = {QuantityKind.ANGLE: "rad", QuantityKind.STRAIN: ""}
        return known[self] if self in known else str(getattr(units, self.value.replace(" ", "_")))


class Channel(NamedTuple):
    """One column of a sensor."""

    name: str
    """"x", "angle", ..."""
    quantity: QuantityKind
    axes: str
    """What its component is along, in words; "" of a scalar"""
    place: str = ""
    """Where it is read, in words, such as the node or the number of nodes; "" where the sensor says it"""


class Located(NamedTuple):
    """What a sensor read, and at which nodes.

    values : (t, c)
    nodes : (t, c)          node ids, as the mesh file has them; None where a value is of no single node
    points : (t, c, 3)      where these nodes lie undeformed, mesh axes
    """

    values: Array
    nodes: IntArray | None = None
    points: Array | None = None


@dataclass(frozen=True, eq=False)
class Reading:
    """What one sensor read.

    name : of the sensor;   channels : of its columns
    times : (t,)            values : (t, c), in the units of the model
    nodes : (t, c)          ids of the nodes that values were read at, where the sensor knows them
    points : (t, c, 3)      where these lie undeformed, mesh axes
    """

    name: str
    channels: tuple[Channel, ...]
    times: Array
    values: Array
    nodes: IntArray | None = None
    points: Array | None = None

    def __post_init__(self) -> None:
        if np.shape(self.values) != (len(self.times), len(self.channels)):
            raise ModelError(
                f"sensor '{self.name}': values of shape {np.shape(self.values)} for {len(self.times)} times "
                f"and {len(self.channels)} channels"
            )
        object.__setattr__(self, "times", read_only(self.times))
        object.__setattr__(self, "values", read_only(self.values))

    @checked_arguments
    def heads(self, units: UnitSystem = UNNAMED) -> Iterator[str]:
        """Heads of its columns, such as "tip.x (m)"."""
        for channel in self.channels:
            own = f"{self.name}.{channel.name}" if channel.name else self.name
            yield labelled(own, channel.quantity.unit(units))

    @checked_arguments
    def plain(self, units: UnitSystem = UNNAMED) -> dict[str, Any]:
        """By channel: unit, axes, smallest, largest and last value, when they are met, and at which node."""
        found = {}
        for number, (channel, column) in enumerate(zip(self.channels, self.values.T, strict=True)):
            low, high = int(np.argmin(column)), int(np.argmax(column))
            found[channel.name or self.name] = {
                "quantity": channel.quantity.value,
                "unit": channel.quantity.unit(units),
                "axes": channel.axes,
                "smallest": float(column[low]),
                "time of smallest": float(self.times[low]),
                "largest": float(column[high]),
                "time of largest": float(self.times[high]),
                "last": float(column[-1]),
                **({"place": channel.place} if channel.place else {}),
                **self._node(number, low, "smallest"),
                **self._node(number, high, "largest"),
            }
        return found

    @property
    def peaks(self) -> IntArray:
        """Numbers of the times (c,) at which the magnitude of each channel is largest."""
        return np.abs(self.values).argmax(axis=0)

    def _node(self, channel: int, time: int, extreme: str) -> dict[str, Any]:
        """The node that an extreme was read at, if it is known."""
        if self.nodes is None or self.points is None:
            return {}
        return {
            f"node of {extreme}": int(self.nodes[time, channel]),
            f"point of {extreme}": self.points[time, channel].tolist(),
        }


@checked_arguments
def write_readings(path: Path | str, readings: Sequence[Reading], *, units: UnitSystem = UNNAMED) -> Path:
    """Write readings of one run as a table, `time, SENSOR.CHANNEL (unit), ...`, with all their digits (CSV).

    Raises
    ------
    ModelError          no reading, or readings of different times
    ResultFileError     the file cannot be written
    """
    times = _common_times(readings)
    heads = [labelled("time", units.time), *(head for each in readings for head in each.heads(units))]
    rows = np.column_stack([times, *(each.values for each in readings)])
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(heads)
        writer.writerows(rows.tolist())
    return Path(path)


@checked_arguments
def write_readings_hdf5(
    path: Path | str, readings: Sequence[Reading], *, units: UnitSystem = UNNAMED
) -> Path:
    """Write readings of one run as HDF5: `time` (t,), and (t, c) by sensor with channels, units and axes.

    Where a sensor knows at which nodes it reads, their ids (t, c) are `NAME.nodes`; its attributes
    `nodes` (c,) and `points` (c, 3) are those where the magnitude of each channel is largest.

    Raises
    ------
    ModelError          no reading, or readings of different times
    ResultFileError     the file cannot be written
    """
    times = _common_times(readings)
    with replacing(path) as temporary, h5py.File(temporary, "w") as file:
        file.create_dataset("time", data=times).attrs["unit"] = units.time
        for each in readings:
            values = file.create_dataset(each.name, data=each.values)
            values.attrs["channels"] = [channel.name for channel in each.channels]
            values.attrs["quantities"] = [channel.quantity.value for channel in each.channels]
            values.attrs["units"] = [channel.quantity.unit(units) for channel in each.channels]
            values.attrs["axes"] = [channel.axes for channel in each.channels]
            if any(channel.place for channel in each.channels):
                values.attrs["places"] = [channel.place for channel in each.channels]
            if each.nodes is not None and each.points is not None:
                channels = np.arange(len(each.channels))
                values.attrs["nodes"] = each.nodes[each.peaks, channels]
                values.attrs["points"] = each.points[each.peaks, channels]
                file.create_dataset(f"{each.name}.nodes", data=each.nodes)
    return Path(path)


@checked_arguments
def as_dataset(readings: Sequence[Reading], *, units: UnitSystem = UNNAMED) -> Any:
    """Readings of one run as an `xarray.Dataset` over `time`: a variable per channel, with unit and axes.

    Raises ModuleNotFoundError where xarray is not installed, ModelError as `write_readings`.
    """
    import xarray  # an optional dependency

    times = _common_times(readings)
    variables = {}
    for each in readings:
        for channel, column in zip(each.channels, each.values.T, strict=True):
            name = f"{each.name}.{channel.name}" if channel.name else each.name
            attributes = {
                "units": channel.quantity.unit(units),
                "axes": channel.axes,
                "place": channel.place,
            }
            variables[name] = ("time", column, {key: word for key, word in attributes.items() if word})
    time = ("time", times, {"units": units.time} if units.time else {})
    return xarray.Dataset(variables, coords={"time": time})


def _common_times(readings: Sequence[Reading]) -> Array:
    if not readings:
        raise ModelError("there is no reading to write: give at least one sensor")
    times = readings[0].times
    for each in readings:
        if not np.array_equal(each.times, times):
            raise ModelError(f"sensor '{each.name}' was read at other times than '{readings[0].name}'")
    return times
