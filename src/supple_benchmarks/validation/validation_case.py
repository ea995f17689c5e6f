"""A validation case: the function that computes it, and its results with their references."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

__all__ = ["Comparison", "ValidationCase", "compared", "largest_difference", "matched"]


@dataclass(frozen=True)
class Comparison:
    """One number and its reference: error = |value - reference| / scale, at most `allowed`.

    `scale` is |reference| by default; with a zero reference it must be given, in the unit of the value,
    because the error would be divided by zero.
    `source` is the origin of the reference: a closed form, a paper and its table, another code and its
    version.
    """

    quantity: str
    value: float
    reference: float
    source: str
    allowed: float
    scale: float | None = None

    @property
    def error(self) -> float:
        """|value - reference| / scale."""
        return abs(self.value - self.reference) / (abs(self.reference) if self.scale is None else self.scale)

    @property
    def holds(self) -> bool:
        """Whether the error is at most the allowed one; False for a value that is not a number."""
        return self.error <= self.allowed


def compared(
    quantities: Iterable[str],
    found: ArrayLike,
    exact: ArrayLike,
    source: str,
    allowed: float,
    scale: float | None = None,
) -> list[Comparison]:
    """Comparisons of several numbers with one source and allowed error; `found` may have more at its end."""
    references = np.ravel(exact).tolist()
    rows = zip(quantities, np.ravel(found).tolist()[: len(references)], references, strict=True)
    return [Comparison(name, own, reference, source, allowed, scale) for name, own, reference in rows]


def largest_difference(
    quantity: str,
    found: ArrayLike,
    exact: ArrayLike,
    source: str,
    allowed: float,
    *,
    scale: float | None = None,
) -> Comparison:
    """Comparison of two histories, (t,) or (t, d): the value is their largest difference, the reference zero.

    found, exact : of equal shape; in (t, d) the difference at each time is the Euclidean norm over d
    scale : divisor of the error; None: the largest absolute value, or norm, of the exact history
    """
    size = np.atleast_1d(np.asarray(exact, dtype=float))
    apart = np.asarray(found) - size
    vectors = size.ndim > 1
    largest = float(np.max(np.linalg.norm(apart, axis=-1) if vectors else np.abs(apart)))
    if scale is None:
        scale = float(np.max(np.linalg.norm(size, axis=-1) if vectors else np.abs(size)))
    return Comparison(f"{quantity}, largest difference", largest, 0.0, source, allowed, scale)


def matched(found: ArrayLike, expected: ArrayLike) -> list[float]:
    """For each expected value the found value that belongs to it; no found value belongs to two of them.

    The sum of the differences is the smallest possible. NaN where `found` has too few values.
    """
    values, wanted = np.ravel(found), np.ravel(expected)
    rows, columns = linear_sum_assignment(np.abs(values[:, None] - wanted))
    nearest = np.full(len(wanted), np.nan)
    nearest[columns] = values[rows]
    return nearest.tolist()


@dataclass(frozen=True)
class ValidationCase:
    """A named problem and the function that computes it; `--quick` leaves out cases with quick=False."""

    name: str
    compare: Callable[[], Sequence[Comparison]]
    quick: bool = True
