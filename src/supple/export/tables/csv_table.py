"""Sensor readings as CSV: a header line, then a line per output time."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from supple.quantities import Readings
from supple.units import UnitSystem

_ROWS = 10_000
"""Rows written at a time."""


def write_csv(path: Path, readings: Readings, units: UnitSystem) -> None:
    """Write the header `Time_[s],tip.x_[m],..` and the values with all their digits."""
    columns = readings.columns(units)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns.heads)
        for start in range(0, len(columns.times), _ROWS):
            rows = slice(start, start + _ROWS)
            writer.writerows(np.column_stack([columns.times[rows], columns.values[rows]]).tolist())
