"""Fixed joint (weld): points and axes coincide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax

from supple.machine.joints.joint import Joint, closing, relative_turn, stack
from supple.machine.pose import Pose

__all__ = ["Fixed"]


@dataclass(frozen=True, kw_only=True)
class Fixed(Joint):
    """Fixed joint: the points of both ends coincide, `r_2 - r_1 = 0`, without relative rotation.

    With the ground as one end, the joint is a clamp.
    """

    n_constraints: ClassVar[int] = 6
    rows: ClassVar[tuple[str, ...]] = (
        "position x",
        "position y",
        "position z",
        "rotation x",
        "rotation y",
        "rotation z",
    )

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """The vector between the points and the relative rotation, (6,)."""
        return stack(closing(first, second), relative_turn(first, second))
