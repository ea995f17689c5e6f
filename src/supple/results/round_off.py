"""Round-off: values that are negligible relative to the largest value of the same quantity."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["without_noise"]

# Motions and forces are accurate to some 1e-12 of their size; tables have five digits.
ROUND_OFF = 1e-9


def without_noise(values: ArrayLike, like: ArrayLike | None = None) -> NDArray[np.float64]:
    """Values for display; magnitudes below 1e-9 of the largest magnitude of the quantity become zero.

    like : other values of the same quantity, such as those in all directions
    """
    numbers = np.asarray(values, dtype=np.float64)
    scale = max(
        np.abs(numbers).max(initial=0.0),
        0.0 if like is None else float(np.abs(np.asarray(like)).max(initial=0.0)),
    )
    return np.where(np.abs(numbers) <= ROUND_OFF * scale, 0.0, numbers)
