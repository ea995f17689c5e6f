"""Damage-equivalent loads of the channels of a case, and the spectrum of their cycles."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Annotated
from warnings import warn

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from supple.errors import SuppleWarning, did_you_mean
from supple.fatigue import Residue, damage_equivalent_load, rainflow
from supple.importers.toml import CheckedTable, Positive

__all__ = ["FatigueLoads", "class_of", "range_of", "summed_spectra"]

Array = NDArray[np.float64]

CLASSES = 20
"""Of the ranges of a spectrum, in each decade."""
_SMALLEST = 1e-3
"""Of the largest range of a channel: smaller ones do no damage that is seen."""


class FatigueLoads(CheckedTable):
    """Which damage-equivalent loads are kept of the cases: `[output.fatigue]`."""

    exponents: Annotated[tuple[Positive, ...], Field(strict=False)] = Field(
        min_length=1,
        description="slopes of S-N curves, such as [4, 10], with a statistic each",
    )
    reference_frequency: Positive = Field(
        1.0, description="reference cycles in a unit of time: N_eq is this times the duration of the run"
    )
    residue: Residue = Field(
        Residue.HALF_CYCLES, strict=False, description='"half cycles" (ASTM E1049-85), or "closed"'
    )
    channels: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        ("*",),
        min_length=1,
        description='names of channels; * stands for any letters: ["joint root.*"]',
    )

    @field_validator("exponents")
    @classmethod
    def _differ(cls, exponents: tuple[float, ...]) -> tuple[float, ...]:
        if len({f"{exponent:g}" for exponent in exponents}) < len(exponents):
            raise ValueError("an exponent stands twice; name each once")
        return exponents

    @property
    def statistics(self) -> tuple[str, ...]:
        """Names of the loads, one for each exponent."""
        return tuple(f"damage-equivalent range, m = {exponent:g}" for exponent in self.exponents)

    @property
    def conventions(self) -> str:
        """What the loads depend on, in words."""
        return (
            f"damage-equivalent ranges peak to peak, {self.reference_frequency:g} reference cycles a unit of "
            f"time, rainflow by ASTM E1049-85, residue as {self.residue.value}, no mean correction"
        )

    def of(self, names: Sequence[str], times: Array, values: Array) -> tuple[Array, Array]:
        """Loads (e, c) of channels, NaN of those not asked for, and the rows (m, 3) of their spectra.

        A row: number of the channel, number of the class of ranges, cycles. Names that match no channel are
        warned of.

        names : (c,)    times : (t,)    values : (t, c)
        """
        matches = np.array([[fnmatchcase(name, own) for own in self.channels] for name in names], dtype=bool)
        matches = matches.reshape(len(names), len(self.channels))
        for own in np.array(self.channels)[~matches.any(axis=0)]:
            warn(
                f"fatigue: no channel is named '{own}'{did_you_mean(own, names)}", SuppleWarning, stacklevel=2
            )
        chosen = np.flatnonzero(matches.any(axis=1))
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


def class_of(ranges: Array) -> NDArray[np.int64]:
    """Numbers of the classes of ranges, which are positive."""
    return np.floor(CLASSES * np.log10(ranges)).astype(np.int64)


def range_of(classes: Array) -> Array:
    """The middle of classes of ranges, on a logarithmic scale."""
    return 10 ** ((np.asarray(classes) + 0.5) / CLASSES)


def summed_spectra(parts: Sequence[Array]) -> Array:
    """Rows (m, 3) of spectra as one, with a row for each class of each channel that has cycles."""
    rows = np.concatenate([np.zeros((0, 3)), *parts])
    places, own = np.unique(rows[:, :2], axis=0, return_inverse=True)
    cycles = np.bincount(own.ravel(), rows[:, 2], minlength=len(places))
    return np.column_stack([places, cycles.astype(np.float64)])
