"""Sensor readings as OpenFAST's binary output (.outb)."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.quantities import Readings
from supple.quantities.reading import TIME, Columns
from supple.units import UnitSystem

_FORMAT = 4
"""File format: equal time steps, values packed to 16 bits, the length of names stated in the file."""
_REACH = 32_500.0
"""Largest packed value; with a rounded offset it still fits in 16 bits."""
_LARGEST_OFFSET = 2.0**25
"""Largest offset; in single precision its rounding error is two packed units at most."""
_EQUAL_STEPS = 1e-6
"""Tolerated deviation from equal spacing, as a fraction of the time step."""
_ROWS = 10_000


def write_outb(path: Path, readings: Readings, units: UnitSystem) -> None:
    """Write the columns, each packed as `round(scale x + offset)` with single-precision scale and offset.

    The error of a value is at most 1/130 000 of the column's span, or 2e-8 of the column's largest magnitude
    if that is more.

    Raises ModelError: output times that are not equally spaced, numbers that are not finite, names that are
    not ASCII.
    """
    columns = readings.columns(units)
    start, step = _equal_steps(columns.times)
    scales, offsets = _packing(columns)
    with path.open("wb") as file:
        names = _words((TIME, *columns.names))
        named_units = _words(f"({unit})" for unit in (columns.time_unit, *columns.units))
        length = max(map(len, names + named_units))
        n_times, n_columns = columns.values.shape
        file.write(struct.pack("<hhii", _FORMAT, length, n_columns, n_times))
        file.write(struct.pack("<dd", start, step))
        file.write(scales.tobytes() + offsets.tobytes())
        file.write(struct.pack("<i", 0))  # length of the description
        for word in names + named_units:
            file.write(word.ljust(length))
        for start in range(0, n_times, _ROWS):
            rows = columns.values[start : start + _ROWS]
            packed = np.rint(rows * scales.astype(float) + offsets.astype(float))
            file.write(packed.astype("<i2").tobytes())


def _equal_steps(times: FloatArray) -> tuple[float, float]:
    """The first time and the step; ModelError for times that are not equally spaced."""
    if len(times) == 1:
        return float(times[0]), 0.0
    step = (times[-1] - times[0]) / (len(times) - 1)
    off = np.abs(times - (times[0] + step * np.arange(len(times)))).max()
    if off > _EQUAL_STEPS * step:
        raise ModelError(
            "an .outb file needs equally spaced output times, and these are not: choose others, or write .csv"
        )
    return float(times[0]), float(step)


def _packing(columns: Columns) -> tuple[NDArray, NDArray]:
    """Single-precision scale and offset (c,) of each column; ModelError for numbers that are not finite."""
    values = columns.values
    finite = np.isfinite(values).all(axis=0)
    if not finite.all():
        name = columns.names[int(np.argmin(finite))]
        raise ModelError(
            f"column '{name}' has numbers that are not finite, which .outb cannot contain; write .csv"
        )
    low, high = values.min(axis=0), values.max(axis=0)
    size, span = np.maximum(np.abs(low), np.abs(high)), high - low
    with np.errstate(divide="ignore"):
        scale = np.minimum(2 * _REACH / span, _LARGEST_OFFSET / size)
    scale = np.where(size > 0, np.clip(scale, 1e-30, 1e30), 1.0).astype("<f4")
    offset = (-scale.astype(float) * (low + high) / 2).astype("<f4")
    return scale, offset


def _words(words: Iterable[str]) -> list[bytes]:
    found = []
    for word in words:
        try:
            found.append(word.encode("ascii"))
        except UnicodeEncodeError as error:
            raise ModelError(
                f"'{word}': an .outb file can contain ASCII names only; rename it, or write .csv, .mat or .nc"
            ) from error
    return found
