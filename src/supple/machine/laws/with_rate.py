"""A law of time together with its rate."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from supple.machine.laws.instants import OfLaws
from supple.machine.laws.time_law import TimeLaw


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class WithRate(OfLaws):
    """`(q(t), dq/dt)`, (2,), for a law whose value is one number."""

    of: TimeLaw

    def __call__(self, time: ArrayLike) -> jax.Array:
        """Value and rate at a time."""
        law = self.of
        now = jnp.asarray(time, dtype=float)
        return jnp.stack(jax.jvp(lambda t: jnp.asarray(law(t), dtype=float), (now,), (jnp.ones(()),)))

    @property
    def parts(self) -> tuple[TimeLaw, ...]:
        """The law."""
        return (self.of,)
