"""Leading directions of a motion, as displacement fields with the size of that motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["leading_fields"]

Array = NDArray[np.float64]


def leading_fields(columns: Array, coordinates: Array, number: int = 1, most: int | None = None) -> Array:
    """Principal directions (n, m) of a motion X c(t), each with its root mean square size times sqrt(number).

    columns : (n, r) X;  coordinates : (t, r)
    number : the directions together have the weight of this number of fields
    most : largest m; default all
    """
    _, sizes, rows = np.linalg.svd(coordinates, full_matrices=False)
    weights = sizes[:most] * np.sqrt(number / len(coordinates))
    return columns @ (rows[:most].T * weights)
