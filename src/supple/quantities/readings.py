"""All readings of one run: a table of named columns with units, over time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import Array
from supple.errors import ModelError
from supple.optional_packages import optional_package
from supple.quantities.reading import Channel, Reading
from supple.summary import Summarized, Summary
from supple.units import UNNAMED, UnitSystem

__all__ = ["Columns", "Readings"]


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

    times: Array
    time_unit: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    channels: tuple[Channel, ...]
    values: Array

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
