"""A fixed vector multiplied by a law of time."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from supple.machine.laws.instants import OfLaws
from supple.machine.laws.law_numbers import Numbers, are_numbers, finite
from supple.machine.laws.time_law import TimeLaw, as_time_law, check_law_shape

__all__ = ["Scaled"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Scaled(OfLaws):
    """`v(t) = vector factor(t)`: a fixed direction, or a fixed pattern over nodes, times a law of time.

    vector : (..., 3)       value of the law where the factor is 1
    factor : a law or function of time whose value is one number
    Raises ModelError for a vector that is not finite, or a factor whose value is not one number.
    """

    vector: Numbers
    factor: Numbers

    def __post_init__(self) -> None:
        if are_numbers(self.vector):
            object.__setattr__(self, "vector", finite("the vector of a scaled law", self.vector))
            object.__setattr__(self, "factor", as_time_law(self.factor))
            check_law_shape("the factor of a scaled law", self.factor, ())

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The vector at a time."""
        return jnp.asarray(self.vector) * self.factor(time)

    @property
    def parts(self) -> tuple[TimeLaw, ...]:
        """The factor."""
        return (self.factor,)
