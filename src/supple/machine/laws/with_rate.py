"""A law of time together with its rate."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike

from supple.machine.laws.instants import instants_of_law, shortest_scale_of
from supple.machine.laws.time_law import TimeLaw

__all__ = ["WithRate"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class WithRate:
    """`(q(t), dq/dt)`, (2,), for a law whose value is one number."""

    of: TimeLaw

    def __call__(self, time: ArrayLike) -> jax.Array:
        """Value and rate at a time."""
        law = self.of
        now = jnp.asarray(time, dtype=float)
        return jnp.stack(jax.jvp(lambda t: jnp.asarray(law(t), dtype=float), (now,), (jnp.ones(()),)))

    @property
    def begin(self) -> float:
        """First time at which the law is defined."""
        return self.of.begin

    @property
    def end(self) -> float:
        """Last time at which the law is defined."""
        return self.of.end

    def instants(self, begin: float, end: float) -> np.ndarray:
        """Instants of the law."""
        return instants_of_law(self.of, begin, end)

    def shortest_scale(self, begin: float, end: float) -> float:
        """Shortest time scale of the law."""
        return shortest_scale_of(self.of, begin, end)
