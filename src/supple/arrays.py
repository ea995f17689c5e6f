"""Types of arrays, and of trees of arrays, in annotations."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

AnyArray: TypeAlias = Any
"""A NumPy or a JAX array: compiled and sparse methods use the same records for their states."""
Tree: TypeAlias = Any
"""A pytree of JAX whose leaves are arrays."""
