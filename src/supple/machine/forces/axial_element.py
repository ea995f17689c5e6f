"""What elements about or along an axis share: the axis, which stays with their first end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from supple.machine.forces.force_element import ForceElement
from supple.machine.joints.joint import axes_along

__all__ = ["AxialElement"]


@dataclass(frozen=True, kw_only=True)
class AxialElement(ForceElement):
    """An element about or along an axis of its first end; the subclasses say what it does.

    axis : direction at the start, global axes; it stays with the first end
    """

    axis: tuple[float, float, float]

    held_by: ClassVar[tuple[str, ...]] = ()
    """Beginnings of the names of a joint's equations that leave it nothing to move; none where it may push
    against a joint."""

    def __post_init__(self) -> None:
        super().__post_init__()
        axes_along(self.axis)  # which refuses what is no direction

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the axis."""
        return axes_along(self.axis)
