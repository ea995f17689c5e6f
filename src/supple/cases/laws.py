"""Laws of time of a case file: its tables become the laws that a script would write."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.cases import law_tables as schema
from supple.errors import ImportFormatError
from supple.machine import Constant, Ramp, Sine, SpinUp, Spline, TimeLaw


def time_law(law: schema.Law, folder: Path) -> TimeLaw:
    """The law of time that a table describes; a table's file lies in or under `folder`.

        constant   `Constant`
        ramp       `Ramp`
        sine       `Sine`
        spin-up    `SpinUp`
        table      `Spline` through the rows of the file

    Raises
    ------
    ImportFormatError   a table file that does not hold two columns of numbers with times that increase
    """
    match law:
        case schema.Constant():
            return Constant(law.value)
        case schema.Ramp():
            return Ramp(law.value, law.duration)
        case schema.Sine():
            return Sine(law.amplitude, law.frequency_hz)
        case schema.SpinUp():
            return SpinUp(law.speed, law.duration)
        case schema.TableLaw():
            return Spline(*read_time_table(folder / law.file))


def read_time_table(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times (k,) and values (k,) of a CSV file with rows `time,value`; # begins a comment."""
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2)
    except ValueError as error:
        raise ImportFormatError(f"{path}: {error}; write rows of two numbers, time,value") from error
    if rows.shape[0] < 2 or rows.shape[1] != 2:
        raise ImportFormatError(
            f"{path} has {rows.shape[0]} rows of {rows.shape[1]} numbers; write two or more rows time,value"
        )
    if not np.isfinite(rows).all():
        raise ImportFormatError(f"{path} holds NaN or infinite numbers; remove these rows")
    backwards = np.flatnonzero(np.diff(rows[:, 0]) <= 0)
    if backwards.size:
        row = int(backwards[0]) + 1
        raise ImportFormatError(
            f"{path}: times must increase, but row {row + 1} has {rows[row, 0]:g} after {rows[row - 1, 0]:g}"
        )
    return rows[:, 0], rows[:, 1]
