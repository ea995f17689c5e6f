"""Watch of the largest values of bodies during a run, and the action at values beyond their limits."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.errors import ValidityError, ValidityWarning
from supple.integrate import Solution, Validity

Peak = tuple[float, float, int]
"""Largest value of a body, its time, and the number of its node or cell."""


@dataclass(frozen=True, eq=False)
class PeakWatch(ABC):
    """Largest values of the bodies of a system, by name."""

    validity: Validity

    @abstractmethod
    def values(self, leg: Solution) -> Iterator[tuple[str, NDArray[np.float64]]]:
        """Name of each body, and its values (t, n) in a part of a run."""

    @abstractmethod
    def excesses(self, peaks: Mapping[str, Peak]) -> list[str]:
        """A message for every value beyond its limit."""

    def observe(self, so_far: Mapping[str, Peak], leg: Solution) -> dict[str, Peak]:
        """Largest values, updated by those of a leg; ValidityError at the first excess if strict."""
        merged = {}
        for name, values in self.values(leg):
            row, place = np.unravel_index(values.argmax(), values.shape)
            found = float(values[row, place]), float(leg.times[row]), int(place)
            merged[name] = max(so_far.get(name, found), found)
        if self.validity.strict:
            for message in self.excesses(merged):
                raise ValidityError(message)
        return merged

    def report(self, peaks: Mapping[str, Peak]) -> None:
        """Warn of every value beyond its limit."""
        for message in self.excesses(peaks):
            warnings.warn(message, ValidityWarning, stacklevel=3)
