"""Laws of time in a case file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from supple import machine
from supple.cases.shared_rules import FileName
from supple.cases.table import Key, Made, OneOf, table_of
from supple.errors import ImportFormatError, ModelError
from supple.importers.text_file import is_file
from supple.importers.time_table import read_time_table
from supple.importers.toml import Mistakes, Positive, Raw, table, tables
from supple.machine import TimeLaw
from supple.machine.laws.time_law import begins_after, ends_before

Constant = table_of(
    machine.Constant, "constant", value=Key(float, "constant angle or slide of a joint, or factor of a load")
)
Ramp = table_of(
    machine.Ramp,
    "ramp",
    value=Key(float, "angle or slide of a joint, or factor of a load, at the end"),
    duration=Key(Positive, "duration of the ramp, a time"),
)
Sine = table_of(
    machine.Sine,
    "sine",
    amplitude=Key(float, "largest angle or slide of a joint, or factor of a load"),
    frequency_hz=Key(Positive, "frequency, periods per time"),
)
SpinUp = table_of(
    machine.SpinUp,
    "spin-up",
    speed=Key(description="rate after the spin-up, rad per time or length per time"),
    rise_time=Key(Positive, "duration of the spin-up, a time", "duration", ...),
)
ConstantRate = table_of(
    machine.ConstantRate,
    "constant-rate",
    rate=Key(float, "constant rate, rad per time or length per time"),
    start=Key(float, "value at t = 0, rad or length"),
)
ONE = Constant(kind="constant", value=1.0)

LARGEST_EXCURSION = 0.01
"""Largest overshoot of a spline, relative to the range of its values; a table above it is rejected.

A sine needs 16 rows per period.
"""


class TableLaw(Made):
    """Values from a file, joined by straight lines (loads) or by a cubic spline (prescribed motions)."""

    kind: Literal["table"]
    file: FileName = Field(description="CSV file of time,value rows beside the case file")

    def build(self, *context: Any) -> TimeLaw:
        """The cubic spline through the rows of the file; `context` is the folder of the file.

        Raises
        ------
        ImportFormatError   a curve that overshoots its rows, as at a jump
        """
        path = context[0] / self.file
        spline = machine.Spline(*read_time_table(path))
        beyond = spline.excursions()
        row = int(np.argmax(beyond))
        if beyond[row] > LARGEST_EXCURSION:
            raise ImportFormatError(
                f"{path}: between rows {row + 1} and {row + 2} (t = {spline.times[row]:g} to "
                f"{spline.times[row + 1]:g}) the smooth curve through the rows overshoots them by "
                f"{100 * beyond[row]:.2g} % of the range of all values; a motion must be smooth: give more "
                "rows there"
            )
        return spline

    def build_of_load(self, *context: Any) -> TimeLaw:
        """Straight lines through the rows, since a spline overshoots where a load jumps."""
        return machine.Table(*read_time_table(context[0] / self.file))


class _LinesLaw(TableLaw):
    """Values from a file, joined by straight lines."""

    build = TableLaw.build_of_load


def tables_suit_the_run(raw: Raw, folder: Path) -> Mistakes:
    """The rule that the table of a law can be read and covers the run, and for a joint does not overshoot."""
    given = table(raw, "simulation")
    duration, begin = given.get("duration"), table(given, "start").get("time", 0.0)
    begin = begin if isinstance(begin, int | float) else 0.0
    for section in ("joint", "load", "element"):
        for path, item in tables(raw, section):
            file = table(item, "law").get("file")
            if table(item, "law").get("kind") != "table" or not isinstance(file, str):
                continue
            if not is_file(folder / file):
                continue  # `_files_exist` reports it
            law = TableLaw(kind="table", file=file)
            place = (*path, "law", "file")
            try:
                made = law.build(folder) if section == "joint" else law.build_of_load(folder)
            except (ImportFormatError, ModelError) as error:
                yield place, str(error)
                continue
            if begins_after(made, begin):
                yield (
                    place,
                    f"the table begins at t = {made.begin:g}, after the run begins (t = {begin:g}); "
                    "extend it backwards",
                )
            if isinstance(duration, int | float) and ends_before(made, begin + duration):
                yield (
                    place,
                    f"the table ends at t = {made.end:g}, before the run ends (t = {begin + duration:g}); "
                    "extend the table or shorten the run",
                )


_LAWS = (Constant, ConstantRate, Ramp, Sine, SpinUp)
Law = Annotated[Made, OneOf(*_LAWS, TableLaw)]
LoadLaw = Annotated[Made, OneOf(*_LAWS, _LinesLaw)]
"""Laws of loads and elements, which may jump."""
