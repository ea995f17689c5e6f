"""S-N curves, and damage by the rule of Palmgren and Miner."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from supple.arguments import Positive, check_fields, check_ranges, checked_arguments
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fatigue.cycle_count import Cycles
from supple.fatigue.equivalent_load import MeanCorrection

__all__ = ["SNCurve", "ThicknessEffect", "miner_damage"]


@dataclass(frozen=True)
class ThicknessEffect:
    """Thicker plates fail earlier: the stress range is multiplied by (t / t_ref)^k where t > t_ref.

    thickness, reference : t, t_ref;   exponent : k

    Source: DNVGL-RP-C203 (2016), section 2.4.
    """

    thickness: Positive
    reference: Positive
    exponent: Positive

    def __post_init__(self) -> None:
        check_fields(self)
        check_ranges("thickness effect", self)

    @property
    def factor(self) -> float:
        """Factor on stress ranges, 1 or more."""
        return max(1.0, self.thickness / self.reference) ** self.exponent


@dataclass(frozen=True)
class SNCurve:
    """Cycles to failure by the stress range, straight or bilinear in logarithms (Basquin).

        N(S) = N_0 (S / S_0)^-m,    with m_2 in place of m where S < S_0

    reference_range, reference_cycles : S_0, in the units of the stress, and N_0: a point of the curve; for a
        bilinear curve, the knee
    exponent : m
    exponent_beyond : m_2, for ranges below S_0; None for a straight curve
    thickness : effect of the plate's thickness, or None

    Curve D in air of DNVGL-RP-C203 is SNCurve(52.63e6, 1e7, 3, 5) in Pa: its log10(a) of 12.164 is
    log10(N_0) + m log10(S_0) with S_0 in MPa.
    """

    reference_range: Positive
    reference_cycles: Positive
    exponent: Positive
    exponent_beyond: Positive | None = None
    thickness: ThicknessEffect | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        check_ranges("S-N curve", self)
        if self.exponent_beyond is not None and self.exponent_beyond < self.exponent:
            raise ModelError(
                f"S-N curve: exponent_beyond ({self.exponent_beyond:g}) is below exponent "
                f"({self.exponent:g}); the curve is flatter at small ranges: exchange them"
            )

    def damage(self, ranges: ArrayLike) -> FloatArray:
        """Damage 1 / N (...) of one cycle of stress ranges (...)."""
        factor = 1.0 if self.thickness is None else self.thickness.factor
        ratio = np.asarray(ranges, dtype=np.float64) * (factor / self.reference_range)
        exponents = self.exponent
        if self.exponent_beyond is not None:
            exponents = np.where(ratio < 1, self.exponent_beyond, self.exponent)
        return ratio**exponents / self.reference_cycles


@checked_arguments
def miner_damage(cycles: Cycles, curve: SNCurve, correction: MeanCorrection | None = None) -> FloatArray:
    """Damage of each channel (...) by the rule of Palmgren and Miner; failure is at 1.

        D = sum_i n_i / N(S_i)

    Parameters
    ----------
    cycles : of stress in the units of the curve, from `rainflow`
    correction : effect of the means, such as `Goodman`

    Raises
    ------
    ModelError      a peak beyond the ultimate stress of the correction

    Source: DNVGL-RP-C203 (2016), 2.2.
    """
    ranges = cycles.ranges if correction is None else correction.corrected(cycles)
    return cycles.total(curve.damage(ranges))
