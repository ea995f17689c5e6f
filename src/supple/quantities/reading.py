"""The readings of sensors over a run: channels over time, and tables of named columns with units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from supple.algebra import read_only
from supple.arguments import checked_arguments
from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.optional_packages import optional_package
from supple.summary import Summarized, Summary
from supple.units import UNNAMED, UnitSystem, labelled

__all__ = ["Columns", "Located", "Reading", "Readings"]


class QuantityKind(Enum):
    """The kind of quantity of a channel; its unit follows from those of the model."""

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
    NUMBER = "number"

    def unit(self, units: UnitSystem) -> str:
        """Name of the unit, "" without a name; angles are in rad, strains and numbers have none."""
        known = {QuantityKind.ANGLE: "rad", QuantityKind.STRAIN: "", QuantityKind.NUMBER: ""}
        return known[self] if self in known else str(getattr(units, self.value.replace(" ", "_")))


class Channel(NamedTuple):
    """One column of a sensor."""

    name: str
    """"x", "angle", ..."""
    quantity: QuantityKind
    axes: str
    """Axes or direction of the component; "" for a scalar"""
    place: str = ""
    """Description of the place, such as the node or number of nodes; "" if the sensor defines the place"""


def vector_channels(axes: str, vectors: Mapping[str, QuantityKind]) -> tuple[Channel, ...]:
    """Channels of the components x, y and z of vectors, by the letters before x."""
    return tuple(Channel(f"{before}{axis}", kind, axes) for before, kind in vectors.items() for axis in "xyz")


LOAD = MappingProxyType({"F": QuantityKind.FORCE, "M": QuantityKind.MOMENT})
"""Letters of a force and a moment, for `vector_channels`."""


class Located(NamedTuple):
    """The values of a sensor, with their nodes.

    values : (t, c)
    nodes : (t, c)          node id of each value in the mesh file; None if values belong to no single node
    points : (t, c, 3)      undeformed positions of these nodes, mesh axes; None without nodes
    """

    values: FloatArray
    nodes: IntArray | None = None
    points: FloatArray | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Reading(Summarized):
    """The reading of one sensor.

    name : name of the sensor;   channels : channels of its columns
    times : (t,)            values : (t, c), in the units of the model
    nodes : (t, c)          node id of each value; None if the values belong to no single node
    points : (t, c, 3)      undeformed positions of these nodes, mesh axes; None without nodes
    """

    name: str
    channels: tuple[Channel, ...]
    times: FloatArray
    values: FloatArray
    nodes: IntArray | None = None
    points: FloatArray | None = None

    def __post_init__(self) -> None:
        if np.shape(self.values) != (len(self.times), len(self.channels)):
            raise ModelError(
                f"sensor '{self.name}': values of shape {np.shape(self.values)} for {len(self.times)} times "
                f"and {len(self.channels)} channels"
            )
        object.__setattr__(self, "times", read_only(self.times))
        object.__setattr__(self, "values", read_only(self.values))

    def summary(self) -> Summary:
        """Smallest and largest value of each channel, in the units of the model."""
        low, high = self.values.min(axis=0, initial=np.inf), self.values.max(axis=0, initial=-np.inf)
        rows = [
            (name, f"{least:.4g} to {most:.4g}, {channel.quantity.value}")
            for name, channel, least, most in zip(self.names, self.channels, low, high, strict=True)
        ]
        return Summary(
            f"Reading '{self.name}' of {len(self.channels)} channels at {len(self.times)} times", rows
        )

    @property
    def names(self) -> Iterator[str]:
        """Names of the columns, such as "tip.x"."""
        return (f"{self.name}.{each.name}" if each.name else self.name for each in self.channels)

    @checked_arguments
    def heads(self, units: UnitSystem = UNNAMED) -> Iterator[str]:
        """Names of the columns with their units, such as "tip.x (m)"."""
        pairs = zip(self.names, self.channels, strict=True)
        return (labelled(name, channel.quantity.unit(units)) for name, channel in pairs)

    @checked_arguments
    def plain(self, units: UnitSystem = UNNAMED) -> dict[str, Any]:
        """By channel: unit, axes, last value, smallest and largest value with their times and nodes."""
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
        """Indices of the times (c,) at which the magnitude of each channel is largest."""
        return np.abs(self.values).argmax(axis=0)

    def _node(self, channel: int, time: int, extreme: str) -> dict[str, Any]:
        """Node and position of the smallest or largest value; empty if there are no nodes."""
        if self.nodes is None or self.points is None:
            return {}
        return {
            f"node of {extreme}": int(self.nodes[time, channel]),
            f"point of {extreme}": self.points[time, channel].tolist(),
        }


def point_words(node: int, point: ArrayLike) -> str:
    """Description of a node, such as "node 17 at (0.5, 0, 0.01)", with the position in mesh axes."""
    return f"node {node} at ({', '.join(f'{x:.4g}' for x in np.asarray(point))})"


TIME = "Time"
"""Name of the first column of every table."""


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of numbers over time, with unique names.

    times : (t,);  time_unit : name of the unit of time, "" if it has none
    names, units : of the c columns, such as "tip.x" and "m"
    channels : channel of each column, with axes and place
    values : (t, c)
    """

    times: FloatArray
    time_unit: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    channels: tuple[Channel, ...]
    values: FloatArray

    @property
    def heads(self) -> Iterator[str]:
        """Names with units, the time first: `Time_[s]`, `tip.x_[m]`; `tip.x` if the unit has no name."""
        pairs = zip((TIME, *self.names), (self.time_unit, *self.units), strict=True)
        return (f"{name}_[{unit}]" if unit else name for name, unit in pairs)


class Readings(Summarized, tuple[Reading, ...]):
    """The readings of sensors over one run, in the order of the sensors."""

    def summary(self) -> Summary:
        """Smallest and largest value of every channel, in the units of the model."""
        rows = [row for each in self for row in each.summary().rows]
        return Summary(f"Readings of {len(self)} sensors at {len(self[0].times) if self else 0} times", rows)

    @checked_arguments
    def columns(self, units: UnitSystem = UNNAMED) -> Columns:
        """The readings as one table.

        Raises ModelError if there is no reading, if readings have different times, or if two columns have the
        same name.
        """
        if not self:
            raise ModelError("there is no reading to write: give at least one sensor")
        times = self[0].times
        for each in self:
            if not np.array_equal(each.times, times):
                raise ModelError(f"sensor '{each.name}' has other times than '{self[0].name}'")
        names = tuple(name for each in self for name in each.names)
        for name in names:
            if (TIME, *names).count(name) > 1:
                raise ModelError(f"two columns would be named '{name}': give the sensors other names")
        channels = tuple(channel for each in self for channel in each.channels)
        return Columns(
            times=times,
            time_unit=units.time,
            names=names,
            units=tuple(channel.quantity.unit(units) for channel in channels),
            channels=channels,
            values=np.column_stack([each.values for each in self]),
        )

    def to_pandas(self, units: UnitSystem = UNNAMED) -> Any:
        """A `pandas.DataFrame` over time with columns such as `tip.x_[m]`.

        Raises ModelError like `columns`; MissingPackageError if pandas is not installed.
        """
        pandas = optional_package("pandas", "a data frame", "xarray")
        columns = self.columns(units)
        time, *heads = columns.heads
        return pandas.DataFrame(columns.values, index=pandas.Index(columns.times, name=time), columns=heads)

    def to_xarray(self, units: UnitSystem = UNNAMED) -> Any:
        """An `xarray.Dataset` over `time`: a variable per channel, with units, axes and place.

        Raises ModelError like `columns`; MissingPackageError if xarray is not installed.
        """
        xarray = optional_package("xarray", "a data set", "xarray")
        columns = self.columns(units)
        variables = {}
        described = zip(columns.names, columns.units, columns.channels, columns.values.T, strict=True)
        for name, unit, channel, column in described:
            attributes = {"units": unit, "axes": channel.axes, "place": channel.place}
            variables[name] = ("time", column, {key: word for key, word in attributes.items() if word})
        time = ("time", columns.times, {"units": units.time} if units.time else {})
        return xarray.Dataset(variables, coords={"time": time})
