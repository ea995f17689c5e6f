"""Point on a line: the second point stays on an axis of the first end; all rotations are free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax

from supple.machine.joints.joint import POSITION, AxialJoint, closing
from supple.machine.pose import Pose

__all__ = ["PointOnLine"]


@dataclass(frozen=True, kw_only=True)
class PointOnLine(AxialJoint):
    """Point on a line, such as a pin in a straight slot: the second end stays on a line of the first end.

    `x_1 . (r_2 - r_1) = y_1 . (r_2 - r_1) = 0`; x_1 and y_1 are axes of the first end, normal to the line.
    """

    rows: ClassVar[tuple[str, ...]] = POSITION[:2]

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """Offset from the line, (2,)."""
        return closing(first, second)[:2]
