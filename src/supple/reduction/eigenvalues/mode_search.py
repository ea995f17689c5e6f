"""Search for the fewest fixed-interface modes that meet a tolerance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from typing import Protocol

import numpy as np

from supple.algebra import ReadOnlyArrays

__all__ = ["Bisection", "ModeSearch", "OneByOne", "SearchStep"]

# A step at most doubles the number of modes: an error that falls slowly at first would predict too many.
LARGEST_GROWTH = 2.0
SMALLEST_GROWTH = 1.05

# Safety factor on the predicted number, so that a further step upwards is seldom needed.
ALLOWANCE = 1.03

# Ratio of the largest error to the tolerance, above which the search for a smaller number of modes ends.
DEEPEST_DIP = 1.1


@dataclass(frozen=True, eq=False)
class SearchStep(ReadOnlyArrays):
    """One trial number of modes.

    n_modes : fixed-interface modes kept
    errors : (N,)            relative error of each elastic eigenvalue; infinite where the body has none
    tolerance : largest error allowed
    criterion : name of the estimator of the errors
    seconds : wall time, s, that of new fixed-interface modes included
    """

    n_modes: int
    errors: np.ndarray
    tolerance: float
    criterion: str
    seconds: float

    @property
    def largest(self) -> float:
        """The largest error."""
        return float(np.max(self.errors, initial=0.0))

    @property
    def first_failing(self) -> int | None:
        """Number, from 1, of the first eigenvalue whose error exceeds the tolerance; None when all pass."""
        failing = np.flatnonzero(~(self.errors <= self.tolerance))
        return int(failing[0]) + 1 if failing.size else None


def search_words(n_modes: int, largest_error: float) -> str:
    """The number of fixed-interface modes and the largest error; "too few" where it is infinite."""
    error = f"error {100 * largest_error:.2g} %" if np.isfinite(largest_error) else "too few"
    return f"{n_modes} modes, {error}"


Trial = Callable[[int], SearchStep]


class ModeSearch(Protocol):
    """OneByOne() or Bisection()."""

    def run(self, trial: Trial, first: int, last: int) -> tuple[SearchStep, ...]:
        """All steps tried between first and last modes; the last step passes unless none does."""
        ...


@dataclass(frozen=True)
class OneByOne:
    """One more mode at a time until every vibration passes. [Han2020] Fig. 1"""

    def run(self, trial: Trial, first: int, last: int) -> tuple[SearchStep, ...]:
        """Steps first, first + 1, .. in order."""
        steps = [trial(first)]
        while steps[-1].first_failing and steps[-1].n_modes < last:
            steps.append(trial(steps[-1].n_modes + 1))
        return tuple(steps)


@dataclass(frozen=True)
class Bisection:
    """Upward steps as the errors predict, at most doubling, then bisection.

    Estimates may cross the tolerance more than once. Smaller numbers than the one found are therefore tried,
    down to where the largest error is 1.1 times the tolerance. The result is that of OneByOne with a fraction
    of the eigensolutions, unless the estimates fall below the tolerance again at a still smaller number.
    """

    def run(self, trial: Trial, first: int, last: int) -> tuple[SearchStep, ...]:
        """Steps in the order tried, the smallest that passes moved to the end."""
        tried = {first: trial(first)}
        highest = first
        while tried[highest].first_failing and highest < last:
            highest = min(last, _promising(list(tried.values())))
            tried[highest] = trial(highest)
        if tried[highest].first_failing:
            return tuple(tried.values())
        passed, failed = highest, max((n for n in tried if n < highest), default=highest - 1)
        while passed - failed > 1:
            middle = (passed + failed) // 2
            tried[middle] = trial(middle)
            passed, failed = (passed, middle) if tried[middle].first_failing else (middle, failed)
        for n in range(passed - 1, first, -1):
            if n not in tried:
                tried[n] = trial(n)
            if tried[n].largest > DEEPEST_DIP * tried[n].tolerance:
                break
        fewest = tried.pop(min(n for n, step in tried.items() if not step.first_failing))
        return (*tried.values(), fewest)


def _promising(steps: list[SearchStep]) -> int:
    """Number at which the power law through the last two steps, error ~ d^-p, p >= 1, meets the tolerance."""
    last = steps[-1]
    rate = 1.0
    if len(steps) > 1 and steps[-2].n_modes and np.isfinite(steps[-2].largest):
        fall = np.log(steps[-2].largest / last.largest)
        rate = max(fall / np.log(last.n_modes / steps[-2].n_modes), 1.0)
    growth = ALLOWANCE * (last.largest / last.tolerance) ** (1.0 / rate)
    growth = min(max(growth, SMALLEST_GROWTH), LARGEST_GROWTH)
    return max(last.n_modes + 1, ceil(growth * last.n_modes))
