"""Laws of time of a case file: its tables become the laws that a script would write."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from supple import machine
from supple.cases.table import Made
from supple.errors import ImportFormatError
from supple.importers.time_table import read_time_table
from supple.importers.toml import CheckedTable, Positive
from supple.machine import TimeLaw


class Constant(Made):
    """value"""

    makes = machine.Constant

    kind: Literal["constant"]
    value: float


class Ramp(Made):
    """From 0 to value in duration with a smooth start and end, then constant."""

    makes = machine.Ramp

    kind: Literal["ramp"]
    value: float
    duration: Positive = Field(description="s")


class Sine(Made):
    """amplitude sin(2 pi frequency_hz t)"""

    makes = machine.Sine

    kind: Literal["sine"]
    amplitude: float
    frequency_hz: Positive = Field(description="Hz")


class SpinUp(Made):
    """An angle (or path) whose rate grows smoothly from 0 to speed in duration, then stays."""

    makes = machine.SpinUp

    kind: Literal["spin-up"]
    speed: float = Field(description="rate after the spin-up, rad/s or m/s")
    duration: Positive = Field(description="s")


LARGEST_EXCURSION = 0.01
"""By which a curve through the rows of a motion may leave their range: sixteen rows a period stay within."""


class TableLaw(CheckedTable):
    """Values from a file, joined by straight lines (loads) or by a cubic spline (prescribed motions)."""

    kind: Literal["table"]
    file: str = Field(description="CSV file of time,value rows beside the case file")

    def build(self, folder: Path) -> TimeLaw:
        """The smooth curve through the rows of the file, which lies in or under `folder`.

        Raises
        ------
        ImportFormatError   a curve that swings beyond its rows, as through a jump
        """
        path = folder / self.file
        spline = machine.Spline(*read_time_table(path))
        beyond = spline.excursions()
        row = int(np.argmax(beyond))
        if beyond[row] > LARGEST_EXCURSION:
            raise ImportFormatError(
                f"{path}: between rows {row + 1} and {row + 2} (t = {spline.times[row]:g} to "
                f"{spline.times[row + 1]:g}) a smooth curve through the rows leaves their range by "
                f"{100 * beyond[row]:.2g} % of all values'; a motion cannot jump: give more rows there"
            )
        return spline

    def build_of_load(self, folder: Path) -> TimeLaw:
        """Straight lines: a spline swings where a load jumps."""
        return machine.Table(*read_time_table(folder / self.file))


Law = Annotated[Constant | Ramp | Sine | SpinUp | TableLaw, Field(discriminator="kind")]
