"""Read-only arrays, the fields of immutable types."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["ReadOnlyArrays", "read_only"]


def read_only(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """Return a private, C-ordered, read-only copy of `values`."""
    array = np.array(values, dtype=dtype, order="C")
    array.flags.writeable = False
    return array


class ReadOnlyArrays:
    """Base of frozen dataclasses whose arrays become private, read-only copies, of float64 or int64."""

    def __post_init__(self) -> None:
        for name, value in list(vars(self).items()):
            if isinstance(value, np.ndarray):
                kind = np.int64 if value.dtype.kind in "iu" else np.float64
                object.__setattr__(self, name, read_only(value, kind))
