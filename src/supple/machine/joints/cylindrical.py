"""Cylindrical joint: rotation about an axis and sliding along it are free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import numpy as np

from supple.machine.joints.joint import Joint, axes_along, closing, stack, tilt
from supple.machine.pose import Pose

__all__ = ["Cylindrical"]


@dataclass(frozen=True, kw_only=True)
class Cylindrical(Joint):
    """Cylindrical joint: the second end stays on the axis of the first end, and both axes stay parallel.

    Rotation about the axis and sliding along it are free.
    """

    axis: tuple[float, float, float]
    """Direction of the axis in the initial configuration, in global components."""

    n_constraints: ClassVar[int] = 4
    rows: ClassVar[tuple[str, ...]] = ("position x", "position y", "tilt about x", "tilt about y")

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the joint's axis."""
        return axes_along(self.axis)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """Offset from the axis and tilt, (4,)."""
        return stack(closing(first, second)[:2], tilt(first, second))
