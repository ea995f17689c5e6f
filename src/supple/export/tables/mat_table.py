"""Sensor readings as a MATLAB file (.mat, version 5)."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import scipy  # its parts are imported when first used

from supple.errors import ModelError
from supple.quantities import Readings
from supple.units import UnitSystem

_LARGEST = 2**31 - 1
"""Largest size of a variable, bytes."""


def write_mat(path: Path, readings: Readings, units: UnitSystem) -> None:
    """Write `time` (t, 1), `values` (t, c) and the cells `names`, `units`, `axes` (1, c), `time_unit`.

    Raises ModelError for values of 2 GiB and more, which the format cannot hold.
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
