"""Revolute joint (hinge): the points and the z axes of both ends coincide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax

from supple.machine.joints.joint import POSITION, TILT, AxialJoint, closing, stack, tilt
from supple.machine.pose import Pose

__all__ = ["Revolute"]


@dataclass(frozen=True, kw_only=True)
class Revolute(AxialJoint):
    """Revolute joint: the points and the axes z of both ends coincide; rotation about the axis is free.

    `r_2 - r_1 = 0` and `z_1 x z_2 = 0`
    """

    rows: ClassVar[tuple[str, ...]] = (*POSITION, *TILT)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """The vector between the points and the tilt of the second axis, (5,)."""
        return stack(closing(first, second), tilt(first, second))
