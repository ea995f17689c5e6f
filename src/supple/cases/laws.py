"""Laws of time of a case file: its tables become the laws that a script would write."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from supple import machine
from supple.cases.table import Made
from supple.errors import ImportFormatError, ModelError
from supple.importers.text_file import is_file
from supple.importers.time_table import read_time_table
from supple.importers.toml import CheckedTable, Mistakes, Positive, Raw, table, tables
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
    duration: Positive = Field(description="a time")


class Sine(Made):
    """amplitude sin(2 pi frequency_hz t)"""

    makes = machine.Sine

    kind: Literal["sine"]
    amplitude: float
    frequency_hz: Positive = Field(description="periods per time")


class SpinUp(Made):
    """An angle (or path) whose rate grows smoothly from 0 to speed in duration, then stays."""

    makes = machine.SpinUp

    kind: Literal["spin-up"]
    speed: float = Field(description="rate after the spin-up: rad or length, per time")
    duration: Positive = Field(description="a time")


class ConstantRate(Made):
    """start + rate t"""

    makes = machine.ConstantRate

    kind: Literal["constant-rate"]
    rate: float = Field(description="rad or length, per time")
    start: float = 0.0


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


def tables_suit_the_run(raw: Raw, folder: Path) -> Mistakes:
    """The rule that a table can be read, as what it is used for, and lasts as long as the run."""
    duration = table(raw, "simulation").get("duration")
    for section in ("joint", "load", "element"):
        for path, item in tables(raw, section):
            file = table(item, "law").get("file")
            if table(item, "law").get("kind") != "table" or not isinstance(file, str):
                continue
            if not is_file(folder / file):
                continue  # said of all files
            law = TableLaw(kind="table", file=file)
            place = (*path, "law", "file")
            try:
                made = law.build(folder) if section == "joint" else law.build_of_load(folder)
            except (ImportFormatError, ModelError) as error:
                yield place, str(error)
                continue
            if made.begin > 0.0:
                yield (
                    place,
                    f"the table begins at t = {made.begin:g}, after the run does; extend it backwards",
                )
            if isinstance(duration, int | float) and made.end < duration * (1.0 - 1e-12):
                yield (
                    place,
                    f"the table ends at t = {made.end:g}, before the run does (t = {duration:g}); extend the "
                    "table or shorten the run",
                )


Law = Annotated[Constant | ConstantRate | Ramp | Sine | SpinUp | TableLaw, Field(discriminator="kind")]
