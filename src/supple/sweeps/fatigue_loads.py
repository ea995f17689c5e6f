"""Damage-equivalent loads of the channels of a case, their rainflow spectra, and loads over a lifetime."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from supple.arrays import FloatArray
from supple.body import FullBody
from supple.cases.case import Case
from supple.cases.result_tables import recorded_quantities
from supple.cases.table import table_of
from supple.errors import CaseError, did_you_mean
from supple.fatigue import Lifetime, Residue, Weibull, damage_equivalent_load, lifetime_of_cases, rainflow
from supple.importers.toml import CheckedTable, Positive
from supple.sweeps.case_table import CaseTable
from supple.sweeps.group_bodies import is_reduced_here
from supple.sweeps.hot_spots import HotSpot, check_hot_spots

__all__ = ["FatigueLoads", "class_of", "range_of", "summed_spectra"]


CLASSES = 20
"""Number of range classes of a spectrum per decade."""
DAMAGE = "damage"
"""Statistic of hot spots: Miner's sum of a case, failure at 1."""
_SMALLEST = 1e-3
"""Fraction of a channel's largest range; ranges up to it are omitted from the spectrum, as negligible."""


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


class FatigueLoads(CheckedTable):
    """Table `[output.fatigue]`: damage-equivalent loads and hot spots of the cases."""

    exponents: Annotated[tuple[Positive, ...], Field(strict=False)] = Field(
        (), description="exponents of S-N curves, such as [4, 10]; each gives a statistic"
    )
    reference_frequency: Positive = Field(
        1.0, description="reference cycles per unit of time; N_eq is this times the duration of the run"
    )
    residue: Residue = Field(
        Residue.HALF_CYCLES, strict=False, description='"half cycles" (ASTM E1049-85), or "closed"'
    )
    channels: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        ("*",),
        min_length=1,
        description='names of channels; * matches any text: ["joint root.*"]',
    )

    hot_spot: Annotated[tuple[HotSpot, ...], Field(strict=False)] = Field(
        (), description="nodes whose damage is computed, each a channel"
    )
    lifetime: LifetimeOfCases | None = Field(
        None, description="frequency of the cases over a lifetime, by their wind speed"
    )

    @model_validator(mode="after")
    def _ask_for_something(self) -> Self:
        if not (self.exponents or self.hot_spot):
            raise ValueError("give exponents, a hot_spot, or both")
        return self

    @field_validator("exponents")
    @classmethod
    def _differ(cls, exponents: tuple[float, ...]) -> tuple[float, ...]:
        if len({f"{exponent:g}" for exponent in exponents}) < len(exponents):
            raise ValueError("an exponent is given twice; give each once")
        return exponents

    @property
    def statistics(self) -> tuple[str, ...]:
        """Names of the statistics: a load for each exponent, and the damage of hot spots."""
        loads = tuple(f"damage-equivalent range, m = {exponent:g}" for exponent in self.exponents)
        return (*loads, DAMAGE) if self.hot_spot else loads

    @property
    def conventions(self) -> str:
        """Description of the conventions of the loads."""
        correction = {spot.name: spot.ultimate for spot in self.hot_spot if spot.ultimate is not None}
        goodman = ", ".join(f"Goodman's for {name} (ultimate {own:g})" for name, own in correction.items())
        return (
            f"damage-equivalent ranges peak to peak, {self.reference_frequency:g} reference cycles per unit "
            f"of time, rainflow by ASTM E1049-85, residue as {self.residue.value}, "
            + (f"mean correction: {goodman}" if goodman else "no mean correction")
        )

    def check(self, case: Case, table: CaseTable) -> None:
        """CaseError for an unknown channel or hot spot, or a wind speed that is no column of numbers.

        The meshes of the case are read if channels or nodes are named.
        """
        check_hot_spots(self.hot_spot, case)
        if self.lifetime is not None:
            self.lifetime.check(table)
        if self.channels == ("*",):
            return
        known = planned_channels(case)
        unknown = np.array(self.channels)[~self._matches(known).any(axis=0)]
        if len(unknown):
            name = str(unknown[0])
            raise CaseError(f"fatigue: no channel is named {name!r}{did_you_mean(name, known)}")

    def _matches(self, names: Sequence[str]) -> NDArray[np.bool_]:
        """Whether each name (c) matches each entry (p) of `channels`, (c, p)."""
        patterns = [own.replace("[", "[[]") for own in self.channels]  # a bracket is part of a name
        found = np.array([[fnmatchcase(name, own) for own in patterns] for name in names], dtype=bool)
        return found.reshape(len(names), len(self.channels))

    def of(
        self, names: Sequence[str], times: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Loads (e, c) of channels for e exponents, and the rows (m, 3) of the spectra of the channels.

        Loads are NaN for channels that are not selected. A row of a spectrum has the index of the channel,
        the number of the range class, and the number of cycles.

        names : (c,)    times : (t,)    values : (t, c)
        """
        chosen = np.flatnonzero(self._matches(names).any(axis=1))
        loads = np.full((len(self.exponents), len(names)), np.nan)
        if not len(chosen):
            return loads, np.zeros((0, 3))
        cycles = rainflow(values[:, chosen], self.residue)
        reference = self.reference_frequency * float(times[-1] - times[0])
        for row, exponent in enumerate(self.exponents):
            loads[row, chosen] = damage_equivalent_load(cycles, exponent, reference).ranges
        seen = cycles.ranges > _SMALLEST * cycles.largest(cycles.ranges)[cycles.channels]
        rows = np.zeros((int(seen.sum()), 3))
        rows[:, 0] = chosen[cycles.channels[seen]]
        rows[:, 1] = class_of(cycles.ranges[seen])
        rows[:, 2] = cycles.counts[seen]
        return loads, summed_spectra([rows])


def class_of(ranges: FloatArray) -> NDArray[np.int64]:
    """Numbers of the classes of positive ranges, floor(20 log10(range))."""
    return np.floor(CLASSES * np.log10(ranges)).astype(np.int64)


def range_of(classes: FloatArray) -> FloatArray:
    """Ranges in the middle of classes, on a logarithmic scale."""
    return 10 ** ((np.asarray(classes) + 0.5) / CLASSES)


def summed_spectra(parts: Sequence[FloatArray]) -> FloatArray:
    """Sum of spectra: rows (m, 3), one for each class of each channel that has cycles."""
    rows = np.concatenate([np.zeros((0, 3)), *parts])
    places, own = np.unique(rows[:, :2], axis=0, return_inverse=True)
    cycles = np.bincount(own.ravel(), rows[:, 2], minlength=len(places))
    return np.column_stack([places, cycles.astype(np.float64)])


def planned_channels(case: Case) -> tuple[str, ...]:
    """Names of all channels of a case, such as "joint root.Fx", in their order.

    Bodies to be reduced are replaced by full bodies: their meshes are read, but no matrix is factored.
    Raises SuppleError for errors of meshes, bodies, joints or sensors.
    """
    full = {
        table.name: FullBody(case.flexible[table.name], table.frame.build())
        for table in case.parts.body
        if is_reduced_here(table) and table.frame is not None
    }
    planned = case.varied(case.tables, full)
    return tuple(
        f"{quantity.name}.{channel.name}" if channel.name else quantity.name
        for quantity in recorded_quantities(planned, planned.system)
        for channel in quantity.channels(planned.system)
    )
