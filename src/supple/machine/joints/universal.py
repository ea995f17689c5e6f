"""Universal (Cardan, Hooke) joint: the points coincide, and two axes stay perpendicular."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import numpy as np

from supple.machine.joints.joint import POSITION, Joint, axes_along, closing, stack
from supple.machine.pose import Pose

__all__ = ["Universal"]


@dataclass(frozen=True, kw_only=True)
class Universal(Joint):
    """Universal joint: the points of both ends coincide, and two axes, one of each end, stay perpendicular.

    Rotations about both axes are free.
    """

    first_axis: tuple[float, float, float]
    """Axis fixed to the first end: direction in the initial configuration, in global components."""
    second_axis: tuple[float, float, float]
    """Axis fixed to the second end, given like `first_axis`; a component along the first axis is removed."""

    rows: ClassVar[tuple[str, ...]] = (*POSITION, "angle between the axes")

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the first axis, x along the second."""
        return axes_along(self.first_axis, hint=self.second_axis)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """The vector between the points and `z_1 . x_2`, (4,)."""
        return stack(closing(first, second), first.axes[:, 2] @ second.axes[:, 0])
