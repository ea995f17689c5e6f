"""Prismatic joint (slider): only sliding along an axis is free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax

from supple.machine.joints.joint import POSITION, ROTATION, AxialJoint, closing, relative_turn, stack
from supple.machine.pose import Pose

__all__ = ["Prismatic"]


@dataclass(frozen=True, kw_only=True)
class Prismatic(AxialJoint):
    """Prismatic joint: the second end slides along an axis of the first end, without relative rotation."""

    rows: ClassVar[tuple[str, ...]] = (*POSITION[:2], *ROTATION)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """Offset from the axis and relative rotation, (5,)."""
        return stack(closing(first, second)[:2], relative_turn(first, second))
