"""Leading directions of a motion, as displacement fields with the size of that motion."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray


def leading_fields(
    columns: FloatArray, coordinates: FloatArray, number: int = 1, most: int | None = None
) -> FloatArray:
    """Principal directions (n, m) of a motion X c(t), each with its root mean square size times sqrt(number).

    columns : (n, r) X;  coordinates : (t, r)
    number : the directions together have the weight of this number of fields
    most : largest m; default all
    """
    _, sizes, rows = np.linalg.svd(coordinates, full_matrices=False)
    weights = sizes[:most] * np.sqrt(number / len(coordinates))
    return columns @ (rows[:most].T * weights)
