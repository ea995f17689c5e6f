"""Lifetime loads and damage from the cases of a sweep: `[output.fatigue.lifetime]`."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from supple.arrays import FloatArray
from supple.cases.table import table_of
from supple.errors import CaseError
from supple.fatigue import Lifetime, Weibull, lifetime_of_cases
from supple.importers.toml import CheckedTable, Positive
from supple.sweeps.case_table import CaseTable


class WindSpeeds(table_of(Weibull)):
    """Table of the Weibull distribution of the wind speeds."""


class LifetimeOfCases(CheckedTable):
    """Table of the lifetime: frequency of the cases by their wind speeds."""

    speed: str = Field(description="column with the wind speed of each case")
    wind: WindSpeeds = Field(description="{ scale, shape } of the Weibull distribution of the wind speeds")
    duration: Positive = Field(description="the lifetime, in the unit of time of the case")
    cut_in: float | None = Field(
        None, description="lower edge of the first bin; default: symmetric about its case"
    )
    cut_out: float | None = Field(
        None, description="upper edge of the last bin; default: symmetric about its case"
    )
    cycles: Positive = Field(1e7, description="reference cycles of the lifetime damage-equivalent loads")

    def check(self, table: CaseTable) -> None:
        """CaseError if the speed is no column of numbers; ModelError for cut-in or cut-out between speeds."""
        table.check_has(self.speed, "fatigue: ")
        if not all(isinstance(value, int | float) for value in table.columns[self.speed]):
            raise CaseError(f"fatigue: the column {self.speed} has texts; give wind speeds as numbers")
        self.of(table, 1.0)

    def of(self, table: CaseTable, durations: FloatArray | float) -> Lifetime:
        """The lifetime with the frequency of each case.

        durations : (n,) durations of the cases, in the unit of time
        """
        speeds = np.asarray(table.columns[self.speed], dtype=np.float64)
        return lifetime_of_cases(
            speeds, durations, self.wind.build(), self.duration, self.cut_in, self.cut_out
        )
