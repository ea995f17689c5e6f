"""Prescribed motion of a root: rotation about an axis, or translation along one, by a law of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from supple.algebra.rotation import rotation_exp
from supple.methods.intrinsic.line_equations import RootTwist

__all__ = ["RootDrive"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class RootDrive:
    """Motion of the root by screw * law(time) from its pose where the law is zero.

    screw : (6,)        a unit translation, then a unit rotation, along the root's axes; one of them zero
    law : TimeLaw       distance or angle; automatic differentiation gives its two derivatives
    rotation, position : (3, 3), (3,)   pose of the root where the law is zero
    """

    screw: Any
    law: Any
    rotation: Any
    position: Any

    def pose(self, time: Any) -> tuple[jax.Array, jax.Array]:
        """Rotation (3, 3) and position (3,) of the root."""
        value = jnp.asarray(self.law(time), dtype=float)
        turned = self.rotation @ rotation_exp(value * self.screw[3:])
        return turned, self.position + value * (self.rotation @ self.screw[:3])

    def twist(self, time: Any) -> RootTwist:
        """The root's velocities, and their rates, along its own axes."""
        time = jnp.asarray(time, dtype=float)
        one = jnp.ones_like(time)

        def value(t: jax.Array) -> jax.Array:
            return jnp.asarray(self.law(t), dtype=float)

        def rate(t: jax.Array) -> jax.Array:
            return jax.jvp(value, (t,), (one,))[1]

        first, second = jax.jvp(rate, (time,), (one,))
        return RootTwist(first * self.screw, second * self.screw)
