"""Fatigue over a lifetime: cases weighted by the frequency of their wind speed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from supple.arguments import Positive, check_fields, check_ranges, checked_arguments
from supple.arrays import FloatArray
from supple.errors import ModelError

__all__ = ["Lifetime", "Weibull", "lifetime_of_cases"]


@dataclass(frozen=True)
class Weibull:
    """Weibull's distribution of wind speeds: F(v) = 1 - exp(-(v / scale)^shape).

    shape : 2 for Rayleigh's distribution, whose mean is scale sqrt(pi) / 2 (IEC 61400-1, 6.3.1.1)
    """

    scale: Positive
    shape: Positive = 2.0

    def __post_init__(self) -> None:
        check_fields(self)
        check_ranges("Weibull", self)

    def below(self, speed: ArrayLike) -> FloatArray:
        """Probability (...) of a speed below `speed` (...)."""
        return -np.expm1(-((np.maximum(speed, 0.0) / self.scale) ** self.shape))

    def quantiles(self, shares: FloatArray) -> FloatArray:
        """Speeds at given cumulative probabilities: v = scale (-ln(1 - F))^(1 / shape)."""
        return self.scale * (-np.log1p(-shares)) ** (1 / self.shape)


@dataclass(frozen=True, eq=False)
class Lifetime:
    """Number of occurrences of each case in a lifetime.

    repeats : (n,) occurrences of each case
    covered : share of the lifetime covered by the bins of the cases; the uncovered share adds no damage
    """

    repeats: FloatArray = field(repr=False)
    covered: float

    def damage(self, damages: ArrayLike) -> FloatArray:
        """Damage (...) in the lifetime, from damages (n, ...) of the cases."""
        return np.tensordot(self.repeats, self._of_cases(damages, "damages"), axes=1)

    def equivalent_load(
        self, loads: ArrayLike, exponent: float, reference_cycles: ArrayLike, lifetime_cycles: float
    ) -> FloatArray:
        """Damage-equivalent range (...) of the lifetime.

            L_life = (sum_j w_j N_j L_j^m / N_life)^(1/m)

        loads : (n, ...) L_j of the cases;   exponent : m;   w_j : the `repeats`
        reference_cycles : N_j, cycles of L_j in one occurrence of the case, a number or (n,)
        lifetime_cycles : N_life, such as 1e7
        """
        ranges = self._of_cases(loads, "loads")
        cycles = np.asarray(reference_cycles, dtype=np.float64)
        if cycles.shape not in ((), self.repeats.shape) or not (cycles > 0).all():
            raise ModelError("lifetime: reference_cycles must be positive, one number or one for each case")
        if not (np.isfinite([exponent, lifetime_cycles]).all() and exponent > 0 and lifetime_cycles > 0):
            raise ModelError("lifetime: exponent and lifetime_cycles must be finite and positive")
        weights = self.repeats * cycles / lifetime_cycles
        largest = ranges.max(axis=0)
        ratios = ranges / np.where(largest > 0, largest, 1.0)
        return largest * np.tensordot(weights, ratios**exponent, axes=1) ** (1 / exponent)

    def _of_cases(self, values: ArrayLike, what: str) -> FloatArray:
        found = np.asarray(values, dtype=np.float64)
        if found.shape[:1] != self.repeats.shape:
            raise ModelError(
                f"lifetime: {what} of shape {found.shape} for {len(self.repeats)} cases; give (n, ...) in "
                "the order of the cases"
            )
        if not np.isfinite(found).all():
            raise ModelError(
                f"lifetime: {what} are not finite in some case; run this case again or leave it out"
            )
        return found


@checked_arguments
def lifetime_of_cases(
    speeds: ArrayLike,
    durations: ArrayLike,
    wind: Weibull,
    lifetime: Positive,
    cut_in: float | None = None,
    cut_out: float | None = None,
) -> Lifetime:
    """Number of occurrences of cases in a lifetime, by their wind speeds.

        w_j = (F(v_b) - F(v_a)) T / sum of the durations of the cases in the bin

    The bin of a case extends from v_a to v_b. Cases of equal speed, such as seeds, share a bin; bins meet
    midway between speeds. The outer bins end at `cut_in` and `cut_out`; by default they are symmetric about
    the lowest and the highest speed.

    Parameters
    ----------
    speeds : (n,) of the cases;   durations : (n,) or a number, in the unit of the lifetime
    wind : distribution F of the speeds
    lifetime : T

    Raises
    ------
    ModelError      durations or a lifetime that are not positive; a single speed without cut_in and cut_out;
                    a cut_in above the lowest speed, or a cut_out below the highest

    Source: IEC 61400-1 (2019).
    """
    at = np.atleast_1d(np.asarray(speeds, dtype=np.float64))
    times = np.broadcast_to(np.asarray(durations, dtype=np.float64), at.shape)
    if at.ndim != 1 or not (np.isfinite(at).all() and np.isfinite(times).all() and (times > 0).all()):
        raise ModelError("lifetime_of_cases: speeds (n,) must be finite, durations finite and positive")
    if not (np.isfinite(lifetime) and lifetime > 0):
        raise ModelError(f"lifetime_of_cases: lifetime must be finite and positive, got {lifetime}")
    centres, bins = np.unique(at, return_inverse=True)
    if len(centres) == 1 and (cut_in is None or cut_out is None):
        raise ModelError("lifetime_of_cases: all cases have the same speed; give cut_in and cut_out")
    edges = np.empty(len(centres) + 1)
    edges[1:-1] = 0.5 * (centres[1:] + centres[:-1])
    edges[0] = 2 * centres[0] - edges[1] if cut_in is None else cut_in
    edges[-1] = 2 * centres[-1] - edges[-2] if cut_out is None else cut_out
    if edges[0] > centres[0] or edges[-1] < centres[-1]:
        raise ModelError(
            f"lifetime_of_cases: the cases have speeds from {centres[0]:g} to {centres[-1]:g}, beyond cut_in "
            f"or cut_out at {edges[0]:g} and {edges[-1]:g}; leave these cases out or move the limits"
        )
    probabilities = np.diff(wind.below(edges))
    weights = probabilities * lifetime / np.bincount(bins, weights=times)
    return Lifetime(weights[bins], float(probabilities.sum()))
