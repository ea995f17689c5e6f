"""Fingerprint of the columns of a basis: a few numbers that identify the columns despite round-off.

Signs of modes are arbitrary, and so are directions of modes with equal frequencies. Round-off decides them,
and another number of threads can change them. The coordinates of a stored motion would then have another
meaning.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["KEY", "measures", "probe", "same_measures"]

KEY = "columns"
"""Key of the fingerprint in the metadata of a result file."""

SAME = 1e-5
"""Relative tolerance of equal fingerprints: round-off is far smaller, another sign or order far larger."""


def probe(size: int, seed: int = 0) -> NDArray[np.float64]:
    """A fixed pseudo-random vector, the same in every call."""
    return np.random.default_rng(seed).standard_normal(size)


def measures(array: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fingerprint: products of the columns of an array (n, ..) with a random vector."""
    return array.T @ probe(len(array))


def same_measures(then: ArrayLike, now: NDArray[np.float64]) -> bool:
    """Whether two fingerprints belong to the same columns."""
    first = np.asarray(then)
    return first.shape == now.shape and bool(
        np.abs(first - now).max(initial=0.0) <= SAME * np.abs(first).max(initial=0.0)
    )
