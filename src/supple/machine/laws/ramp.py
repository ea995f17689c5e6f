"""A quantity that rises smoothly to a constant value."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike

from supple.machine.laws.instants import times_within
from supple.machine.laws.law_numbers import Numbers, UnboundedLaw, are_numbers, finite, finite_and_positive

__all__ = ["Ramp"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Ramp(UnboundedLaw):
    """Rise from zero to a value, with continuous first and second derivatives.

        q(t) = value s^3 (10 - 15 s + 6 s^2),   s = t / duration, limited to [0, 1]

    value : number or array     q from the time `duration` on
    duration : float            duration of the rise, which begins at t = 0; in s, positive
    Raises ModelError for a value that is not finite, or a duration that is not finite and positive.
    """

    value: Numbers
    duration: Numbers

    def __post_init__(self) -> None:
        if are_numbers(self.value, self.duration):
            object.__setattr__(self, "value", finite("the value of a ramp", self.value))
            object.__setattr__(
                self, "duration", finite_and_positive("the duration of a ramp, in s,", self.duration)
            )

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The value at a time."""
        s = jnp.clip(time / self.duration, 0.0, 1.0)
        return self.value * (s**3 * (10.0 + s * (-15.0 + 6.0 * s)))

    def instants(self, begin: float, end: float) -> np.ndarray:
        """Times of the begin and the end of the rise that are strictly between `begin` and `end`."""
        return times_within([0.0, self.duration], begin, end)

    def shortest_scale(self, begin: float, end: float) -> float:
        """The duration of the rise; infinite if no part of the rise is between `begin` and `end`."""
        return float(self.duration) if begin < self.duration and end > 0 else float("inf")
