"""Derivatives by central differences of fourth order, rejected for functions that are not smooth.

    f' = (8 (f_1 - f_-1) - (f_2 - f_-2)) / (12 h),        error h^4 f^(5) / 30

at f_-2, f_-1, f_1, f_2, steps h apart. The differences

    f_2 - 2 f_1 + 2 f_-1 - f_-2,        f_-2 - 4 f_-1 + 6 f_0 - 4 f_1 + f_2

are of order h^3 and h^4 for a smooth function, and of order h at a kink. At a jump, or for a wave no longer
than the steps, they are of the order of the function itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["OFFSETS", "central_difference", "looks_smooth"]

OFFSETS = (-2, -1, 1, 2)
"""Evaluation points besides the middle, in steps."""
_SMOOTH = 1e-3
"""Largest of these differences, relative to the change from the first value to the last: the derivative of a
sine is then accurate to 1e-7."""
_ROUNDING = 1e-8
"""Largest difference relative to the values: the accuracy of positions at rest."""
_NOTHING = 1e-6
"""Least reference value: rounding errors of zero are not functions of a parameter."""


def central_difference(values: Sequence[ArrayLike], step: float) -> NDArray[np.float64]:
    """Derivative from four values, at `OFFSETS` times the step."""
    far_below, below, above, far_above = (np.asarray(own, dtype=float) for own in values)
    return (8 * (above - below) - (far_above - far_below)) / (12 * step)


def looks_smooth(middle: ArrayLike, values: Sequence[ArrayLike], size: float = 0.0) -> bool:
    """Whether a derivative from these values is one of a smooth function.

    size : least reference for the values
    """
    far_below, below, above, far_above = (np.asarray(own, dtype=float) for own in values)
    third = far_above - 2 * (above - below) - far_below
    fourth = far_below + far_above - 4 * (below + above) + 6 * np.asarray(middle, dtype=float)
    change = np.max(np.abs(far_above - far_below), initial=0.0)
    largest = np.max(np.abs(np.asarray(middle, dtype=float)), initial=max(size, _NOTHING))
    allowed = _SMOOTH * change + _ROUNDING * largest
    # In this form NaN is not smooth.
    return all(bool(np.max(np.abs(own), initial=0.0) <= allowed) for own in (third, fourth))
