"""Vectors given in rotating axes."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike

from supple.algebra import read_only
from supple.arguments import check_numbers
from supple.errors import ModelError
from supple.machine.laws.instants import OfLaws
from supple.machine.laws.law_numbers import Numbers, are_numbers
from supple.machine.laws.sampled_law import law_samples
from supple.machine.laws.time_law import TimeLaw, as_time_law

__all__ = ["Turning"]

N_SPEEDS = 257
"""Number of times at which the angular velocity of the axes is sampled."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Turning(OfLaws):
    """Vectors given in rotating axes: v(t) = R(axis, angle(t)) vectors(t), R by Rodrigues' formula.

    vectors : components (..., 3) in the rotating axes: a constant, a law or a function of time
    axis : (3,) unit vector of the axis of rotation, in the fixed axes
    angle : angle of rotation of the axes, rad: a number, a law or a function of time

    If `angle` is a `Table`, the rotation is exact also between its rows. A table of the rotated vectors would
    be interpolated along chords.
    Raises ModelError for an axis that is not a unit vector.
    """

    vectors: Numbers
    axis: Numbers
    angle: Numbers

    def __post_init__(self) -> None:
        if not are_numbers(self.axis):
            return
        check_numbers("the axis of turning vectors", self.axis)
        axis = read_only(self.axis)
        if axis.shape != (3,) or not abs(np.linalg.norm(axis) - 1) < 1e-9:
            raise ModelError(f"the axis of turning vectors must be a unit vector, got {self.axis}")
        object.__setattr__(self, "axis", axis)
        object.__setattr__(self, "vectors", as_time_law(self.vectors))
        object.__setattr__(self, "angle", as_time_law(self.angle))

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The vectors at a time, in the fixed axes."""
        v, a, angle = jnp.asarray(self.vectors(time)), jnp.asarray(self.axis), self.angle(time)
        along = (v @ a)[..., None] * a
        return along + jnp.cos(angle) * (v - along) + jnp.sin(angle) * jnp.cross(a, v)

    @property
    def parts(self) -> tuple[TimeLaw, ...]:
        """Vectors and angle."""
        return self.vectors, self.angle

    def shortest_scale(self, begin: float, end: float) -> float:
        """Shortest of the time scales of vectors and angle, and of the time of the fastest revolution."""
        times = np.linspace(begin, end, N_SPEEDS)
        fastest = float(np.max(np.abs(law_samples(self.angle, times, order=1)[1]), initial=0.0))
        turn = 2 * np.pi / fastest if fastest > 0 else float("inf")
        return min(turn, super().shortest_scale(begin, end))
