"""What the cases of a sweep come to over a lifetime: loads and damage, `[output.fatigue.lifetime]`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from supple.cases.table import table_of
from supple.errors import CaseError, did_you_mean
from supple.fatigue import Lifetime, Weibull, lifetime_of_cases
from supple.importers.toml import CheckedTable, Positive
from supple.sweeps.case_table import CaseTable

__all__ = ["LifetimeOfCases"]

Array = NDArray[np.float64]


class WindSpeeds(table_of(Weibull)):
    """Weibull's distribution of the wind speeds."""


class LifetimeOfCases(CheckedTable):
    """How often the cases occur, by the wind speed that each stands for."""

    speed: str = Field(description="path whose values are the wind speeds of the cases")
    wind: WindSpeeds = Field(description="{ scale, shape } of Weibull's distribution of the wind speeds")
    duration: Positive = Field(description="the lifetime, in the unit of time of the case")
    cut_in: float | None = Field(None, description="lowest speed; left out: as far below as above")
    cut_out: float | None = Field(None, description="highest speed; left out: as far above as below")
    cycles: Positive = Field(1e7, description="reference cycles of damage-equivalent loads of the lifetime")

    def check(self, table: CaseTable) -> None:
        """CaseError where the speed is no column of numbers; ModelError for cuts between speeds."""
        if self.speed not in table.columns:
            raise CaseError(
                f"fatigue: the speed {self.speed!r} does not vary{did_you_mean(self.speed, table.columns)}"
            )
        if not all(isinstance(value, int | float) for value in table.columns[self.speed]):
            raise CaseError(f"fatigue: {self.speed} holds no numbers that could be wind speeds")
        self.of(table, 1.0)

    def of(self, table: CaseTable, durations: Array | float) -> Lifetime:
        """How often each case occurs.

        durations : (n,) of the cases, in the unit of time
        """
        speeds = np.asarray(table.columns[self.speed], dtype=np.float64)
        return lifetime_of_cases(
            speeds, durations, self.wind.build(), self.duration, self.cut_in, self.cut_out
        )
