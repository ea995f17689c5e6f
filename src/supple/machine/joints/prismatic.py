"""Prismatic joint (slider): only sliding along an axis is free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import numpy as np

from supple.machine.joints.joint import Joint, axes_along, closing, relative_turn, stack
from supple.machine.pose import Pose

__all__ = ["Prismatic"]


@dataclass(frozen=True, kw_only=True)
class Prismatic(Joint):
    """Prismatic joint: the second end slides along an axis of the first end, without relative rotation."""

    axis: tuple[float, float, float]
    """Direction of the axis in the initial configuration, in global components."""

    n_constraints: ClassVar[int] = 5
    rows: ClassVar[tuple[str, ...]] = ("position x", "position y", "rotation x", "rotation y", "rotation z")

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the joint's axis."""
        return axes_along(self.axis)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """Offset from the axis and relative rotation, (5,)."""
        return stack(closing(first, second)[:2], relative_turn(first, second))
