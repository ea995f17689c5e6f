"""Fixed joint (weld): points and axes coincide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import numpy as np

from supple.machine.joints.joint import POSITION, ROTATION, Joint, axes_along, closing, relative_turn, stack
from supple.machine.pose import Pose

__all__ = ["Fixed"]


@dataclass(frozen=True, kw_only=True)
class Fixed(Joint):
    """Fixed joint: the points of both ends coincide, `r_2 - r_1 = 0`, without relative rotation.

    With the ground as one end, the joint is a clamp.
    """

    axis: tuple[float, float, float] | None = None
    """Z axis of the joint forces in the initial configuration, global; default: global z."""
    x_axis: tuple[float, float, float] | None = None
    """Direction in the initial configuration, global; the x axis is as near it as possible."""

    rows: ClassVar[tuple[str, ...]] = (*POSITION, *ROTATION)

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along `axis`, x as near `x_axis` as possible; by default the global axes."""
        return axes_along((0.0, 0.0, 1.0) if self.axis is None else self.axis, hint=self.x_axis)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """The vector between the points and the relative rotation, (6,)."""
        return stack(closing(first, second), relative_turn(first, second))
