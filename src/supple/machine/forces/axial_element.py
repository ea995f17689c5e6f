"""Base of elements about or along an axis, which is fixed to their first end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from supple.machine.forces.force_element import ForceElement
from supple.machine.joints.joint import axes_along

__all__ = ["AxialElement"]


@dataclass(frozen=True, kw_only=True)
class AxialElement(ForceElement):
    """An element about or along an axis of its first end; subclasses define its force.

    axis : direction at the start, global axes; it is fixed to the first end
    """

    axis: tuple[float, float, float]

    blocked_by: ClassVar[tuple[str, ...]] = ()
    """Joint equations, named without axis, that prevent the element's motion (an error); empty: no check."""

    def __post_init__(self) -> None:
        super().__post_init__()
        axes_along(self.axis)  # raises for a vector without direction

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the axis."""
        return axes_along(self.axis)
