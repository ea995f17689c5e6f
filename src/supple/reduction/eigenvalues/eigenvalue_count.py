"""Proof by Sturm counts alone that the eigenvalues of a reduced body are within a tolerance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from supple.algebra import count_below
from supple.body import FlexibleBody
from supple.errors import ModelError

__all__ = ["CountedGroup", "count_eigenvalues"]

N_RIGID = 6

# Eigenvalues whose relative distance is below this fraction of the tolerance share one count at first.
CLOSE = 0.5


@dataclass(frozen=True)
class CountedGroup:
    """Elastic eigenvalues first .. last (from 1) of a reduced body, and one count for the full body.

    shift   : sigma = chi-bar_last / (1 + tolerance), rad^2/s^2
    counted : number of elastic eigenvalues of the full body below the shift
    """

    first: int
    last: int
    shift: float
    counted: int

    @property
    def proven(self) -> bool:
        """True if at most first - 1 eigenvalues lie below the shift: chi-bar_n <= (1 + tolerance) chi_n."""
        return self.counted < self.first


def count_eigenvalues(body: FlexibleBody, values: ArrayLike, tolerance: float) -> tuple[CountedGroup, ...]:
    """Prove chi-bar_n <= (1 + tolerance) chi_n for every n by the negative eigenvalues of K - sigma M.

    If at most n - 1 elastic eigenvalues lie below sigma_n = chi-bar_n / (1 + tolerance), then chi_n >=
    sigma_n. Close eigenvalues share one count, at the largest of their shifts; if it proves nothing, the
    group is split. Each count needs a sparse factorisation: slower than `enclose_eigenvalues`, but based on
    Sylvester's law alone.

    values : (N,)     chi-bar, elastic eigenvalues of a reduced body, ascending
    Returns CountedGroup, in the order of the eigenvalues; the claim holds where all are proven.
    Raises
    ------
    ModelError      tolerance or values not positive, values not ascending
    AccuracyError   a shift hits an eigenvalue
    """
    chi = np.asarray(values, dtype=np.float64)
    if not tolerance > 0 or chi.ndim != 1 or not np.all(chi > 0) or np.any(np.diff(chi) < 0):
        raise ModelError(
            f"eigenvalues of body '{body.name}' can be counted for a positive tolerance (here {tolerance:g}) "
            "and positive, ascending eigenvalues"
        )
    groups: list[CountedGroup] = []
    first = 0
    while first < chi.size:
        last = int(np.searchsorted(chi, chi[first] * (1 + CLOSE * tolerance), side="right")) - 1
        groups += _counted(body, chi, first, last, tolerance)
        first = last + 1
    return tuple(groups)


def _counted(
    body: FlexibleBody, chi: np.ndarray, first: int, last: int, tolerance: float
) -> list[CountedGroup]:
    shift = float(chi[last]) / (1 + tolerance)
    below = count_below(body.stiffness, body.mass, shift, grounded=body.grounded_stiffness)
    group = CountedGroup(first + 1, last + 1, shift, below - N_RIGID)
    if group.proven or first == last:
        return [group]
    middle = (first + last) // 2
    return _counted(body, chi, first, middle, tolerance) + _counted(body, chi, middle + 1, last, tolerance)
