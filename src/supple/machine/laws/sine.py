"""A quantity that oscillates at one frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from supple.machine.laws.law_numbers import Numbers, SmoothLaw, are_numbers, finite

__all__ = ["Sine"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Sine(SmoothLaw):
    """`q(t) = amplitude sin(2 pi frequency_hz t)`.

    amplitude : number or array
    frequency_hz : float    Hz
    Raises ModelError for numbers that are not finite.
    """

    amplitude: Numbers
    frequency_hz: Numbers

    def __post_init__(self) -> None:
        if are_numbers(self.amplitude, self.frequency_hz):
            object.__setattr__(self, "amplitude", finite("the amplitude of a sine", self.amplitude))
            object.__setattr__(
                self, "frequency_hz", finite("the frequency of a sine, in Hz,", self.frequency_hz)
            )

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The value at a time."""
        return self.amplitude * jnp.sin(2.0 * math.pi * self.frequency_hz * time)

    def shortest_scale(self, begin: float, end: float) -> float:  # noqa: ARG002
        """The period; infinite for a frequency of zero."""
        frequency = abs(float(self.frequency_hz))
        return 1.0 / frequency if frequency > 0 else float("inf")
