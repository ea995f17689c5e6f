"""Read-only arrays, the fields of immutable types."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["read_only"]


def read_only(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """Return a private, C-ordered, read-only copy of `values`."""
    array = np.array(values, dtype=dtype, order="C")
    array.flags.writeable = False
    return array
