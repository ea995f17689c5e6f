"""A quantity with a constant rate, such as the angle of a drive at constant speed."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax.typing import ArrayLike

from supple.machine.laws.law_numbers import Numbers, SmoothLaw, are_numbers, finite

__all__ = ["ConstantRate"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class ConstantRate(SmoothLaw):
    """Linear law `q(t) = start + rate t`.

    If the law prescribes a motion, the initial velocities of the bodies must agree with the rate. Otherwise
    the run corrects them, with a warning.

    Raises ModelError for numbers that are not finite.
    """

    rate: Numbers
    start: Numbers = 0.0

    def __post_init__(self) -> None:
        if are_numbers(self.rate, self.start):
            object.__setattr__(self, "rate", finite("the rate of a law of constant rate", self.rate))
            object.__setattr__(self, "start", finite("the start of a law of constant rate", self.start))

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The value at a time."""
        return self.start + self.rate * time
