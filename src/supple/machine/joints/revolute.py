"""Revolute joint (hinge): the points and the z axes of both ends coincide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import numpy as np

from supple.machine.joints.joint import Joint, axes_along, closing, stack, tilt
from supple.machine.pose import Pose

__all__ = ["Revolute"]


@dataclass(frozen=True, kw_only=True)
class Revolute(Joint):
    """Revolute joint: the points and the axes z of both ends coincide; rotation about the axis is free.

    `r_2 - r_1 = 0` and `z_1 x z_2 = 0`
    """

    axis: tuple[float, float, float]
    """Direction of the axis in the initial configuration, in global components."""

    n_constraints: ClassVar[int] = 5
    rows: ClassVar[tuple[str, ...]] = (
        "position x",
        "position y",
        "position z",
        "tilt about x",
        "tilt about y",
    )

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the joint's axis."""
        return axes_along(self.axis)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """The vector between the points and the tilt of the second axis, (5,)."""
        return stack(closing(first, second), tilt(first, second))
