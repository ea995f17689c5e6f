"""Kinks and time scales of laws of time, which time steps must resolve."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, runtime_checkable

import numpy as np

from supple.machine.laws.sampled_law import sampled_instants
from supple.machine.laws.time_law import TimeLaw

BENDS = 1e-6
"""Limit of J h^n / (range of the values), above which a row is a kink.

J : jump of the derivative of order n;   h : smaller spacing to an adjacent row
"""


@runtime_checkable
class KnownLaw(Protocol):
    """A law that returns its kinks and time scales; other laws are sampled, which can miss short features."""

    def instants(self, begin: float, end: float) -> np.ndarray:
        """Times (k,) strictly between `begin` and `end` at which a derivative jumps or a short event ends."""
        ...

    def shortest_scale(self, begin: float, end: float) -> float:
        """Shortest period, rise time or spacing of rows between `begin` and `end`; infinite without any."""
        ...


def instants_of_law(law: TimeLaw, begin: float, end: float) -> np.ndarray:
    """Ascending times (k,) strictly between `begin` and `end` at which time steps should end."""
    if isinstance(law, KnownLaw):
        return law.instants(begin, end)
    return sampled_instants(law, begin, end)


class OfLaws:
    """Base of laws that are functions of other laws, at the same time."""

    @property
    def parts(self) -> tuple[TimeLaw, ...]:
        """The other laws."""
        raise NotImplementedError

    @property
    def begin(self) -> float:
        """First time at which all parts are defined."""
        return max(law.begin for law in self.parts)

    @property
    def end(self) -> float:
        """Last time at which all parts are defined."""
        return min(law.end for law in self.parts)

    def instants(self, begin: float, end: float) -> np.ndarray:
        """Instants of the parts, ascending."""
        return np.unique(np.concatenate([instants_of_law(law, begin, end) for law in self.parts]))

    def shortest_scale(self, begin: float, end: float) -> float:
        """Shortest time scale of the parts."""
        return min(shortest_scale_of(law, begin, end) for law in self.parts)


_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def uneven_times(begin: float, end: float, number: int) -> np.ndarray:
    """Times (number,) in [begin, end) without a period: fractions k phi mod 1, k = 0, 1, .., of the interval.

    phi is the golden ratio; the times do not ascend. Equally spaced times could all be zeros of a sine.
    """
    return begin + (end - begin) * (np.arange(number) * _GOLDEN % 1.0)


def shortest_scale_of(law: TimeLaw, begin: float, end: float) -> float:
    """Shortest time scale of a `KnownLaw` from `begin` to `end`; infinite for other laws."""
    return law.shortest_scale(begin, end) if isinstance(law, KnownLaw) else float("inf")


def times_within(times: Iterable[float] | np.ndarray, begin: float, end: float) -> np.ndarray:
    """The times strictly between `begin` and `end`, ascending, without duplicates."""
    unique = np.unique(np.asarray(times, dtype=float))
    return unique[(unique > begin) & (unique < end)]


def rows_that_bend(times: np.ndarray, values: np.ndarray, jumps: np.ndarray, power: int) -> np.ndarray:
    """Times of the first and the last row of a table, and of the inner rows that are kinks (`BENDS`).

    times, values : (k,) and (k, ...) of the rows
    jumps : (k - 2, m), jumps of the derivative of order `power` at the inner rows
    """
    spacing = np.minimum(np.diff(times)[:-1], np.diff(times)[1:])
    size = float(np.max(np.ptp(values, axis=0), initial=0.0))
    largest = np.abs(jumps).max(axis=1, initial=0.0)
    bends = largest * spacing**power > BENDS * size
    return times[np.concatenate([[True], bends, [True]])]
