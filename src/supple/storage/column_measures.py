"""What tells the columns of a basis from others, in a few numbers that round-off hardly moves.

Vibrations have no sign of their own, and those of like frequency no directions: round-off decides, and
another number of threads is enough to change it. A motion on disk would then mean another one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["KEY", "measures", "probe", "same_measures"]

KEY = "columns"
"""Of the metadata of a result file that hold them."""

SAME = 1e-5
"""Of the largest measure: round-off moves columns by far less, another sign or order by far more."""


def probe(size: int, seed: int = 0) -> NDArray[np.float64]:
    """A random vector, the same every time."""
    return np.random.default_rng(seed).standard_normal(size)


def measures(array: NDArray[np.float64]) -> NDArray[np.float64]:
    """Products of the columns of an array (n, ..) with a random vector."""
    return array.T @ probe(len(array))


def same_measures(then: ArrayLike, now: NDArray[np.float64]) -> bool:
    """Whether measures are those of the same columns."""
    first = np.asarray(then)
    return first.shape == now.shape and bool(
        np.abs(first - now).max(initial=0.0) <= SAME * np.abs(first).max(initial=0.0)
    )
