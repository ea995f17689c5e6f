"""Ball joint: the two points coincide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax

from supple.machine.joints.joint import POSITION, Joint, closing
from supple.machine.pose import Pose

__all__ = ["Ball"]


@dataclass(frozen=True, kw_only=True)
class Ball(Joint):
    """Ball joint: the points of both ends coincide, `r_2 - r_1 = 0`; all rotations are free."""

    rows: ClassVar[tuple[str, ...]] = POSITION

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """The vector between the points, (3,)."""
        return closing(first, second)
