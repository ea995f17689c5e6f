"""Types of arrays in annotations, by the kind of their numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Array", "BoolArray", "FloatArray", "IntArray"]

Array = NDArray[np.float64]
FloatArray = Array
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
