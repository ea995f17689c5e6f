"""Proven accuracy of the eigenvalues of a reduced body, and the search for its size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from supple.algebra import ReadOnlyArrays
from supple.reduction.eigenvalues.eigenvalue_enclosure import EigenvalueEnclosure
from supple.reduction.eigenvalues.mode_search import SearchStep

__all__ = ["EigenvalueCertificate"]


@dataclass(frozen=True, eq=False)
class EigenvalueCertificate(ReadOnlyArrays):
    """The elastic eigenvalues of a free reduced body, with bounds for those of the full body.

    tolerance : relative error allowed in each eigenvalue
    values : (N,)                chi-bar, of the reduced body, rad^2/s^2, ascending
    enclosure : EigenvalueEnclosure     of the full body
    n_fixed_interface_modes : number of fixed-interface modes in the reduced body
    estimated : (N,)             relative errors by the estimator of the basis
    steps : all numbers of modes tried; the last is the one taken
    seconds : wall time of modes, search and proof
    """

    tolerance: float
    values: np.ndarray
    enclosure: EigenvalueEnclosure
    n_fixed_interface_modes: int
    estimated: np.ndarray
    steps: tuple[SearchStep, ...] = field(repr=False)
    seconds: Mapping[str, float] = field(default_factory=dict)

    @property
    def errors(self) -> np.ndarray:
        """(N,) proven upper bounds of the relative errors chi-bar_n / chi_n - 1."""
        return self.values / self.enclosure.lower - 1.0

    @property
    def largest_error(self) -> float:
        """The largest entry of `errors`."""
        return float(self.errors.max())

    def __str__(self) -> str:
        return (
            f"{self.values.size} eigenvalues, each within {100 * self.tolerance:g} %, none missed "
            f"(largest error {100 * self.largest_error:.3g} %, "
            f"{self.n_fixed_interface_modes} fixed-interface modes)"
        )
