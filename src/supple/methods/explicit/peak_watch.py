"""Watch of the largest values of bodies during a run."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.equations.checks.strictness import Watch
from supple.integrate import Solution

Peak = tuple[float, float, int]
"""Largest value of a body, its time, and the number of its node or cell."""


@dataclass(frozen=True, eq=False)
class PeakWatch(Watch[Peak]):
    """Largest values of the bodies of a system, by name."""

    @abstractmethod
    def values(self, leg: Solution) -> Iterator[tuple[str, NDArray[np.float64]]]:
        """Name of each body, and its values (t, n) in a part of a run."""

    def updated(self, so_far: Mapping[str, Peak], leg: Solution) -> dict[str, Peak]:
        """Largest values, updated by those of a leg."""
        merged = {}
        for name, values in self.values(leg):
            row, place = np.unravel_index(values.argmax(), values.shape)
            found = float(values[row, place]), float(leg.times[row]), int(place)
            merged[name] = max(so_far.get(name, found), found)
        return merged
