"""Laws of time of a case file: its tables become the laws that a script would write."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from supple import machine
from supple.errors import ImportFormatError
from supple.importers.toml import CheckedTable, Positive
from supple.machine import TimeLaw


class Constant(CheckedTable):
    """value"""

    kind: Literal["constant"]
    value: float


class Ramp(CheckedTable):
    """From 0 to value in duration with a smooth start and end, then constant."""

    kind: Literal["ramp"]
    value: float
    duration: Positive = Field(description="s")


class Sine(CheckedTable):
    """amplitude sin(2 pi frequency_hz t)"""

    kind: Literal["sine"]
    amplitude: float
    frequency_hz: Positive = Field(description="Hz")


class SpinUp(CheckedTable):
    """An angle (or path) whose rate grows smoothly from 0 to speed in duration, then stays."""

    kind: Literal["spin-up"]
    speed: float = Field(description="rate after the spin-up, rad/s or m/s")
    duration: Positive = Field(description="s")


class TableLaw(CheckedTable):
    """Values from a file, joined by a curve that is smooth enough for prescribed motion (cubic spline)."""

    kind: Literal["table"]
    file: str = Field(description="CSV file of time,value rows beside the case file")


Law = Annotated[Constant | Ramp | Sine | SpinUp | TableLaw, Field(discriminator="kind")]


def time_law(law: Law, folder: Path) -> TimeLaw:
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
        case Constant():
            return machine.Constant(law.value)
        case Ramp():
            return machine.Ramp(law.value, law.duration)
        case Sine():
            return machine.Sine(law.amplitude, law.frequency_hz)
        case SpinUp():
            return machine.SpinUp(law.speed, law.duration)
        case TableLaw():
            return machine.Spline(*read_time_table(folder / law.file))


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
