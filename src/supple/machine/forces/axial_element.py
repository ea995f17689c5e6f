"""Base of force elements with an axis, which is fixed to the first end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from supple.machine.forces.force_element import ForceElement
from supple.machine.joints.joint import axes_along

__all__ = ["AxialElement"]


@dataclass(frozen=True, kw_only=True)
class AxialElement(ForceElement):
    """A force element with an axis fixed to its first end; subclasses define its force.

    axis : direction in the initial configuration, global axes, of any length
    Raises ModelError for an axis without a direction.
    """

    axis: tuple[float, float, float]

    blocked_by: ClassVar[tuple[str, ...]] = ()
    """Names in `Joint.rows`, without the axis, of equations that prevent the element's motion.

    A `System` with such a joint between the same ends is an error. Empty: no check.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        axes_along(self.axis)  # raises for a vector without direction

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the axis."""
        return axes_along(self.axis)
