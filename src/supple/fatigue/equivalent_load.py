"""Damage-equivalent loads: the constant range with the damage of a history."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from supple.algebra import read_only
from supple.arguments import Positive, check_numbers, checked_arguments
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fatigue.cycle_count import Cycles

__all__ = ["EquivalentLoad", "Goodman", "MeanCorrection", "damage_equivalent_load"]


class MeanCorrection(Protocol):
    """Effect of the mean of a cycle on its range."""

    def corrected(self, cycles: Cycles) -> FloatArray:
        """Ranges (c,) about a mean of zero with the same damage."""
        ...


@dataclass(frozen=True)
class Goodman:
    """Goodman's correction: S_0 = S / (1 - |M| / L_ult), range S about the mean M.

    ultimate : L_ult > 0, load or stress at failure; a number, or one for each channel (...)

    Source: Hayman, MLife theory manual (NREL, 2012), with a fixed mean of zero.
    """

    ultimate: ArrayLike

    def __post_init__(self) -> None:
        check_numbers("Goodman, ultimate", self.ultimate)
        ultimate = np.asarray(self.ultimate, dtype=np.float64)
        if not (np.isfinite(ultimate) & (ultimate > 0)).all():
            raise ModelError(f"Goodman: ultimate must be finite and positive, got {self.ultimate}")
        object.__setattr__(self, "ultimate", read_only(ultimate))

    def corrected(self, cycles: Cycles) -> FloatArray:
        """Ranges (c,) about a mean of zero; ModelError where a peak reaches the ultimate load."""
        try:
            ultimate = np.broadcast_to(self.ultimate, cycles.shape).ravel()[cycles.channels]
        except ValueError:
            raise ModelError(
                f"Goodman: ultimate of shape {np.shape(self.ultimate)} for channels of shape "
                f"{cycles.shape}; give one number, or one for each channel"
            ) from None
        peaks = np.abs(cycles.means) + 0.5 * cycles.ranges
        if (peaks >= ultimate).any():
            worst = int(np.argmax(peaks / ultimate))
            raise ModelError(
                f"Goodman: channel {cycles.channels[worst]} reaches {peaks[worst]:.6g}, beyond its ultimate "
                f"load of {ultimate[worst]:.6g}: immediate failure; give the ultimate load in "
                "the units of the history"
            )
        return cycles.ranges / (1 - np.abs(cycles.means) / ultimate)


@dataclass(frozen=True, eq=False)
class EquivalentLoad:
    """Damage-equivalent ranges, with the conventions by which they were computed.

    ranges : (...) one per channel, peak to peak, in the units of the history
    exponent, reference_cycles, correction : as for `damage_equivalent_load`;   residue : value of a `Residue`
    """

    ranges: FloatArray = field(repr=False)
    exponent: float
    reference_cycles: float
    residue: str
    correction: MeanCorrection | None = None

    @property
    def conventions(self) -> str:
        """Description of the conventions of the numbers."""
        mean = "no mean correction" if self.correction is None else f"mean correction {self.correction}"
        return (
            f"ranges peak to peak, exponent {self.exponent:g}, {self.reference_cycles:g} reference cycles, "
            f"rainflow by ASTM E1049-85, residue as {self.residue}, {mean}"
        )

    def __str__(self) -> str:
        shown = np.array2string(self.ranges, precision=6, threshold=12)
        return f"damage-equivalent load {shown} ({self.conventions})"


@checked_arguments
def damage_equivalent_load(
    cycles: Cycles, exponent: Positive, reference_cycles: Positive, correction: MeanCorrection | None = None
) -> EquivalentLoad:
    """The constant range that does the damage of a history in `reference_cycles` cycles.

        L_eq = (sum_i n_i S_i^m / N_eq)^(1/m)

    for each channel; 0 for a channel without cycles.

    Parameters
    ----------
    cycles : of `rainflow`
    exponent : m, slope of the S-N curve: 3 to 5 for welded steel, 8 to 12 for composites
    reference_cycles : N_eq; the duration in seconds for loads of 1 Hz
    correction : effect of the means, such as `Goodman`

    Raises
    ------
    ModelError      exponent or reference cycles that are not positive, a peak beyond the ultimate load

    Source: IEC 61400-1 (2019); Hayman, MLife theory manual (NREL, 2012).
    """
    if not (
        np.isfinite(exponent) and exponent > 0 and np.isfinite(reference_cycles) and reference_cycles > 0
    ):
        raise ModelError(
            "damage_equivalent_load: exponent and reference_cycles must be finite and positive, got "
            f"{exponent} and {reference_cycles}"
        )
    ranges = cycles.ranges if correction is None else correction.corrected(cycles)
    # Powers of ratios to the largest range do not overflow.
    largest = cycles.largest(ranges)
    scale = np.where(largest > 0, largest, 1.0)
    ratios = ranges / scale.ravel()[cycles.channels]
    load = largest * (cycles.total(ratios**exponent) / reference_cycles) ** (1 / exponent)
    return EquivalentLoad(
        read_only(load), float(exponent), float(reference_cycles), cycles.residue.value, correction
    )
