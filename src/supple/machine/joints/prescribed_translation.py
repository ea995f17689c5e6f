"""Prescribed translation: the displacement of the second end along an axis of the first end is given."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp

from supple.machine.joints.fixed import Fixed
from supple.machine.joints.joint import AxialJoint, closing, relative_turn, stack
from supple.machine.laws.time_law import OverTime, TimeLaw, as_time_law
from supple.machine.pose import Pose

__all__ = ["PrescribedTranslation"]


@dataclass(frozen=True, kw_only=True)
class PrescribedTranslation(AxialJoint):
    """A fixed joint whose second end moves along an axis of the first end by a given distance over time."""

    displacement: OverTime
    """Distance from the initial configuration: a number, a law, or a function of time in `jax.numpy`."""

    rows: ClassVar[tuple[str, ...]] = Fixed.rows

    @property
    def law(self) -> TimeLaw:
        """The prescribed displacement."""
        return as_time_law(self.displacement)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:
        """Actual minus prescribed vector between the points, and the relative rotation, (6,)."""
        offset = closing(first, second) - value * jnp.array([0.0, 0.0, 1.0])
        return stack(offset, relative_turn(first, second))
