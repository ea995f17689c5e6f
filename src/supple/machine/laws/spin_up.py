"""A prescribed rotation from rest to a constant speed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike

from supple.arguments import check_number
from supple.errors import ModelError
from supple.machine.laws.instants import times_within
from supple.machine.laws.law_numbers import UnboundedLaw, are_numbers

__all__ = ["SpinUp"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class SpinUp(UnboundedLaw):
    """Prescribed rotation whose speed rises smoothly to omega_s at the time T_s and is constant afterwards.

        theta(t) = omega_s / T_s [t^2 / 2 + (T_s / 2 pi)^2 (cos(2 pi t / T_s) - 1)]     t <= T_s
                 = omega_s (t - T_s / 2)                                                t >  T_s

    Angle, speed and acceleration are continuous. For a prescribed translation, theta is a displacement and
    the speed is in m/s.

    Parameters
    ----------
    speed : float       omega_s, final speed, rad/s; negative for a rotation in the opposite direction
    rise_time : float   T_s, s, positive

    Raises
    ------
    ModelError  a speed that is not finite, or a rise time that is not finite and positive
    Source: [Wu2019], section 6.1
    """

    speed: float
    rise_time: float = 15.0

    def __post_init__(self) -> None:
        if not are_numbers(self.speed, self.rise_time):
            return
        check_number("SpinUp, speed", self.speed)
        check_number("SpinUp, rise_time", self.rise_time)
        if not np.isfinite(self.speed):
            raise ModelError(f"the spin-up speed is {self.speed}: give a finite speed in rad/s")
        if not (np.isfinite(self.rise_time) and self.rise_time > 0.0):
            raise ModelError(f"the spin-up rise time is {self.rise_time}: give a positive time in s")
        object.__setattr__(self, "speed", float(self.speed))
        object.__setattr__(self, "rise_time", float(self.rise_time))

    def __call__(self, time: ArrayLike) -> jax.Array:
        """Angle theta(t) in rad; its shape is that of `time`."""
        t = jnp.asarray(time, dtype=float)
        radian_time = self.rise_time / (2.0 * math.pi)
        ripple = radian_time**2 * (jnp.cos(t / radian_time) - 1.0)
        rising = self.speed / self.rise_time * (0.5 * t**2 + ripple)
        return jnp.where(t <= self.rise_time, rising, self.speed * (t - 0.5 * self.rise_time))

    def instants(self, begin: float, end: float) -> np.ndarray:
        """The rise time, if it is strictly between `begin` and `end`."""
        return times_within([self.rise_time], begin, end)

    def shortest_scale(self, begin: float, end: float) -> float:  # noqa: ARG002 - begin decides
        """The rise time; infinite if `begin` is after it."""
        return self.rise_time if begin < self.rise_time else float("inf")
