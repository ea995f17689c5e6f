"""Cylindrical joint: rotation about an axis and sliding along it are free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax

from supple.machine.joints.joint import POSITION, TILT, AxialJoint, closing, stack, tilt
from supple.machine.pose import Pose

__all__ = ["Cylindrical"]


@dataclass(frozen=True, kw_only=True)
class Cylindrical(AxialJoint):
    """Cylindrical joint: the second end stays on the axis of the first end, and both axes stay parallel.

    Rotation about the axis and sliding along it are free.
    """

    rows: ClassVar[tuple[str, ...]] = (*POSITION[:2], *TILT)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """Offset from the axis and tilt, (4,)."""
        return stack(closing(first, second)[:2], tilt(first, second))
