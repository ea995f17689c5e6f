"""Sensor readings as netCDF, by xarray."""

from __future__ import annotations

from pathlib import Path

from supple.errors import ModelError
from supple.quantities import Readings
from supple.units import UnitSystem


def write_netcdf(path: Path, readings: Readings, units: UnitSystem) -> None:
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
