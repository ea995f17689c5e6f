"""Sensor readings written as a table; the suffix of the path selects the format."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from supple.arguments import checked_arguments
from supple.errors import ModelError, did_you_mean
from supple.export.tables.csv_table import write_csv
from supple.export.tables.hdf5_table import write_hdf5
from supple.export.tables.mat_table import write_mat
from supple.export.tables.netcdf_table import write_netcdf
from supple.export.tables.openfast_table import write_outb
from supple.quantities import Reading, Readings
from supple.storage.atomic_write import replacing
from supple.units import UNNAMED, UnitSystem

__all__ = ["TABLE_SUFFIXES", "write_readings"]

_WRITERS: Mapping[str, Callable[[Path, Readings, UnitSystem], None]] = MappingProxyType(
    {".csv": write_csv, ".h5": write_hdf5, ".mat": write_mat, ".nc": write_netcdf, ".outb": write_outb}
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
