"""A law of time given by times and values, with linear interpolation."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike

from supple.machine.laws.instants import rows_that_bend, times_within
from supple.machine.laws.law_numbers import Numbers, OfRows, are_numbers, increasing_rows

__all__ = ["Table"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Table(OfRows):
    """Linear interpolation between rows, each a time and a value.

    The first derivative jumps at the rows. A table is therefore suitable for loads; a prescribed motion needs
    a `Spline`. The rows must cover the whole run; otherwise the run raises ModelError.

    times : (k,)        s, increasing, k >= 2
    values : (k, ...)   one row for each time
    Raises ModelError for arrays of other shapes, NaN or infinite entries, or times that do not increase.
    """

    times: Numbers
    values: Numbers

    def __post_init__(self) -> None:
        if are_numbers(self.times, self.values):
            times, values = increasing_rows(self.times, self.values)
            object.__setattr__(self, "times", times)
            object.__setattr__(self, "values", values)

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The value at a time, or values (*times, *row) at times of any shape.

        Outside the rows, the first or last interval is extrapolated linearly.
        """
        upper = jnp.clip(jnp.searchsorted(self.times, time, side="right"), 1, len(self.times) - 1)
        t0, t1 = jnp.asarray(self.times)[upper - 1], jnp.asarray(self.times)[upper]
        v0, v1 = jnp.asarray(self.values)[upper - 1], jnp.asarray(self.values)[upper]
        along = (time - t0) / (t1 - t0)
        return v0 + (v1 - v0) * jnp.expand_dims(along, tuple(range(along.ndim, v0.ndim)))

    def instants(self, begin: float, end: float) -> np.ndarray:
        """Times of the rows strictly between `begin` and `end`, except inner rows without a jump of slope."""
        times, values = np.asarray(self.times), np.asarray(self.values, dtype=float)
        slopes = np.diff(values.reshape(len(times), -1), axis=0) / np.diff(times)[:, None]
        return times_within(rows_that_bend(times, values, np.diff(slopes, axis=0), 1), begin, end)
