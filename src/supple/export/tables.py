"""Sensor readings written as a table; the suffix of the path selects the format."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import h5py
import numpy as np
import scipy  # its parts are imported when first used

from supple.arguments import checked_arguments
from supple.errors import ModelError, did_you_mean
from supple.export.openfast_table import write_outb
from supple.quantities import Reading, Readings
from supple.storage.atomic_write import replacing
from supple.storage.dataset_labels import name_taken_in_hdf5
from supple.units import UNNAMED, UnitSystem

__all__ = ["TABLE_SUFFIXES", "write_readings"]

_ROWS = 10_000
"""Rows of a CSV file written at a time."""
_LARGEST = 2**31 - 1
"""Largest size of a variable of a .mat file, bytes."""


def _write_csv(path: Path, readings: Readings, units: UnitSystem) -> None:
    """Write CSV: the header `Time_[s],tip.x_[m],..` and the values with all their digits."""
    columns = readings.columns(units)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns.heads)
        for start in range(0, len(columns.times), _ROWS):
            rows = slice(start, start + _ROWS)
            writer.writerows(np.column_stack([columns.times[rows], columns.values[rows]]).tolist())


def _write_hdf5(path: Path, readings: Readings, units: UnitSystem) -> None:
    """Write `time` (t,), and for each sensor its values (t, c) with channels, units and axes as attributes.

    For a sensor at nodes, `NAME.nodes` (t, c) has the ids of the nodes. The attributes `nodes` (c,) and
    `points` (c, 3) are the id and the position of the node at which each channel has its largest magnitude.

    Raises ModelError for a name that HDF5 cannot have beside the others.
    """
    times = readings.columns(units).times
    names = [each.name for each in readings]
    for name in names:
        if reason := name_taken_in_hdf5(name, names):
            raise ModelError(f"sensor '{name}': {reason}")
    # Built in memory, because a failed write crashes HDF5: see reserve_space.
    with h5py.File("image", "w", driver="core", backing_store=False) as file:
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
        file.flush()
        path.write_bytes(file.id.get_file_image())


def _write_mat(path: Path, readings: Readings, units: UnitSystem) -> None:
    """Write `time` (t, 1), `values` (t, c) and the cells `names`, `units`, `axes` (1, c), `time_unit`.

    Raises ModelError for values of 2 GiB and more, which the format (version 5) cannot hold.
    """
    columns = readings.columns(units)
    if columns.values.nbytes > _LARGEST:
        raise ModelError(
            f"{columns.values.nbytes / 2**30:.1f} GiB of readings, and a variable of a .mat file holds 2 GiB "
            "at most: write fewer output times or sensors, or a .nc or .h5 file"
        )
    variables = {
        "time": columns.times[:, None],
        "time_unit": columns.time_unit,
        "values": columns.values,
        "names": _cells(columns.names),
        "units": _cells(columns.units),
        "axes": _cells(channel.axes for channel in columns.channels),
    }
    with path.open("wb") as file:
        scipy.io.savemat(file, variables)


def _cells(words: Iterable[str]) -> np.ndarray:
    return np.array([list(words)], dtype=object)


def _write_netcdf(path: Path, readings: Readings, units: UnitSystem) -> None:
    """Write a variable per channel over `time`, with units, axes and place (netCDF 3, 64-bit offsets).

    Raises ModelError for a name that contains "/", which netCDF does not allow.
    """
    data = readings.to_xarray(units)
    for name in data:
        if "/" in str(name):
            raise ModelError(
                f"column '{name}': netCDF allows no '/' in names; rename it, or write a .mat file"
            )
    with path.open("wb") as file:
        file.write(data.to_netcdf(engine="scipy", format="NETCDF3_64BIT"))


_WRITERS: Mapping[str, Callable[[Path, Readings, UnitSystem], None]] = MappingProxyType(
    {".csv": _write_csv, ".h5": _write_hdf5, ".mat": _write_mat, ".nc": _write_netcdf, ".outb": write_outb}
)

TABLE_SUFFIXES = tuple(_WRITERS)
"""Suffixes of the formats."""


@checked_arguments
def write_readings(path: Path | str, readings: Sequence[Reading], *, units: UnitSystem = UNNAMED) -> Path:
    """Write the sensor readings of one run as a table over time; returns the path.

    The suffix selects the format: .csv (text), .h5 (HDF5), .mat (MATLAB), .nc (netCDF) or .outb (OpenFAST).
    Columns are named `Time`, `SENSOR.CHANNEL`; see docs/how-to/export.md.

    Raises
    ------
    ModelError          another suffix; no reading; readings at different times; two columns of one name;
                        values or names that the format cannot hold
    ResultFileError     the file cannot be written
    MissingPackageError netCDF without xarray
    """
    path = Path(path)
    write = _WRITERS.get(path.suffix.lower())
    if write is None:
        near, known = did_you_mean(path.suffix, TABLE_SUFFIXES), ", ".join(TABLE_SUFFIXES)
        raise ModelError(
            f"cannot write {path}: no table format has the suffix '{path.suffix}'{near}; use {known}"
        )
    with replacing(path) as temporary:
        write(temporary, Readings(readings), units)
    return path
