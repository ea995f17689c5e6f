"""Prescribed rotation: the angle of the second end relative to the first, about an axis, is given."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp

from supple.machine.joints.fixed import Fixed
from supple.machine.joints.joint import AxialJoint, closing, relative_turn, stack
from supple.machine.laws.time_law import OverTime, TimeLaw, as_time_law
from supple.machine.pose import Pose

__all__ = ["PrescribedRotation"]


@dataclass(frozen=True, kw_only=True)
class PrescribedRotation(AxialJoint):
    """A fixed joint whose second end rotates about an axis of the first end by a given angle over time."""

    angle: OverTime
    """Angle from the initial configuration, rad: a number, a law, or a function of time in `jax.numpy`."""

    rows: ClassVar[tuple[str, ...]] = Fixed.rows

    @property
    def law(self) -> TimeLaw:
        """The prescribed angle."""
        return as_time_law(self.angle)

    @staticmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:
        """The vector between the points, and the rotation from prescribed to actual axes, (6,)."""
        cosine, sine = jnp.cos(value), jnp.sin(value)
        about_z = jnp.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        turned = first._replace(axes=first.axes @ about_z)
        return stack(closing(first, second), relative_turn(turned, second))
