"""Derivatives by central differences of fourth order, rejected for functions that are not smooth.

    f' = (8 (f_1 - f_-1) - (f_2 - f_-2)) / (12 h),        error h^4 f^(5) / 30

where f_k is the value at k h from the middle. The differences

    f_2 - 2 f_1 + 2 f_-1 - f_-2,        f_-2 - 4 f_-1 + 6 f_0 - 4 f_1 + f_2

are of order h^3 and h^4 for a smooth function, and of order h at a kink. At a jump, or for an oscillation
with a wavelength of h or less, they are of the order of the function itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from supple.arrays import FloatArray

OFFSETS = (-2, -1, 1, 2)
"""Evaluation points besides the middle, in steps."""
_SMOOTH = 1e-3
"""Largest of these differences for a smooth function, relative to |f_2 - f_-2|: the derivative of a sine is
then accurate to 1e-7."""
_ROUNDING = 1e-8
"""Additional allowance for these differences, relative to f_0: the accuracy of positions at rest."""
_NOTHING = 1e-6
"""Smallest reference value for `_ROUNDING`: below it, values count as rounding errors of zero."""


def central_difference(values: Sequence[ArrayLike], step: float) -> FloatArray:
    """Derivative from four values, at `OFFSETS` times the step."""
    far_below, below, above, far_above = (np.asarray(own, dtype=float) for own in values)
    return (8 * (above - below) - (far_above - far_below)) / (12 * step)


def looks_smooth(middle: ArrayLike, values: Sequence[ArrayLike], size: float = 0.0) -> bool:
    """Whether f_0 and four values, at `OFFSETS` times the step, appear to be those of a smooth function.

    size : smallest reference value for rounding errors
    """
    far_below, below, above, far_above = (np.asarray(own, dtype=float) for own in values)
    third = far_above - 2 * (above - below) - far_below
    fourth = far_below + far_above - 4 * (below + above) + 6 * np.asarray(middle, dtype=float)
    change = np.max(np.abs(far_above - far_below), initial=0.0)
    largest = np.max(np.abs(np.asarray(middle, dtype=float)), initial=max(size, _NOTHING))
    allowed = _SMOOTH * change + _ROUNDING * largest
    # NaN does not satisfy the inequality, and thus is not smooth.
    return all(bool(np.max(np.abs(own), initial=0.0) <= allowed) for own in (third, fourth))
