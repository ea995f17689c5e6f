"""Arrays that cannot be written: what immutable types hold."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["read_only"]


def read_only(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """Return a private, C-ordered copy of `values` that refuses assignment."""
    array = np.array(values, dtype=dtype, order="C")
    array.flags.writeable = False
    return array
