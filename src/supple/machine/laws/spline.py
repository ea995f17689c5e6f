"""A quantity given by times and values, interpolated by a cubic spline, also for prescribed motions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import scipy  # its parts are imported when first used
from jax.typing import ArrayLike

from supple.algebra import read_only
from supple.machine.laws.instants import rows_that_bend, times_within
from supple.machine.laws.law_numbers import Numbers, OfRows, increasing_rows

__all__ = ["Spline"]

_FEW = 4
"""Rows of a table that has at most one inner piece."""


@dataclass(frozen=True, eq=False)
class Spline(OfRows):
    """Cubic spline through rows, each a time and a value.

    Value, first and second derivative are continuous between the first and the last row, and the third also
    at the rows next to these two: nothing is assumed of speed and acceleration at the ends. Outside the rows,
    `law(time)` is the value of the nearest row. The rows must cover the whole run, for a load and for a
    prescribed motion: otherwise the run raises ModelError.

    times : (k,)        s, increasing, k >= 2
    values : (k, ...)   one row for each time
    Raises ModelError for arrays of other shapes, NaN or infinite entries, or times that do not increase.
    """

    times: Numbers
    values: Numbers
    coefficients: Numbers = field(init=False, repr=False)
    """(4, k - 1, ...) coefficients of the cubics, cubic term first; time begins at the start of a piece."""

    def __post_init__(self) -> None:
        times, values = increasing_rows(self.times, self.values)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)
        # Not the natural spline: its zero acceleration at the ends is an error of first order in the spacing
        # of the rows in the speed at the start, and of the whole acceleration in the driving forces there.
        spline = scipy.interpolate.CubicSpline(times, values, bc_type="not-a-knot")
        object.__setattr__(self, "coefficients", read_only(spline.c))

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The value at a time, or values (*times, *row) at times of any shape."""
        starts = jnp.asarray(self.times)[:-1]
        first, last = self.times[0], self.times[-1]
        # Not jnp.clip: its derivative at the first and the last row is half of that between the rows.
        t = jnp.where(time < first, first, jnp.where(time > last, last, time))
        piece = jnp.clip(jnp.searchsorted(starts, t, side="right") - 1, 0, len(starts) - 1)
        cubics, within = jnp.asarray(self.coefficients)[:, piece], t - starts[piece]
        return jnp.polyval(cubics, jnp.expand_dims(within, tuple(range(within.ndim, cubics.ndim - 1))))

    def instants(self, begin: float, end: float) -> np.ndarray:
        """Times of the rows strictly between `begin` and `end`, except inner rows without a kink.

        A kink is a jump of the third derivative.
        """
        times, values = np.asarray(self.times), np.asarray(self.values, dtype=float)
        third = 6.0 * np.asarray(self.coefficients)[0].reshape(len(times) - 1, -1)
        return times_within(rows_that_bend(times, values, np.diff(third, axis=0), 3), begin, end)

    def excursions(self) -> np.ndarray:
        """Overshoot (k - 1,) of each piece beyond the four rows around it, relative to the range of all rows.

        The four rows are those at the ends of the piece, and one more on either side. The overshoot is below
        one per cent for smooth data. At a jump of the data the spline oscillates. With five rows or more, the
        overshoot of the first and the last piece is not counted: they have rows on one side only, and a jump
        there overshoots in the next piece too.
        """
        times, values = np.asarray(self.times), np.asarray(self.values, dtype=float)
        values = values.reshape(len(times), -1)
        within = np.linspace(0.0, 1.0, 33)[:, None, None] * np.diff(times)[:, None]
        piece = np.polyval(np.asarray(self.coefficients).reshape(4, len(times) - 1, -1), within)
        padded = np.concatenate([values[:1], values, values[-1:]])
        around = np.array([padded[i : i + len(times) - 1] for i in range(4)])
        beyond = np.maximum(piece.max(axis=0) - around.max(axis=0), around.min(axis=0) - piece.min(axis=0))
        if len(times) > _FEW:
            beyond[[0, -1]] = 0.0
        size = np.ptp(values, axis=0)
        return np.max(beyond / np.where(size > 0, size, 1.0), axis=1, initial=0.0)


def _from_leaves(_: None, leaves: Any) -> Spline:
    # Without `__post_init__`, which would compute the coefficients again, from traced rows.
    law = object.__new__(Spline)
    for name, leaf in zip(("times", "values", "coefficients"), leaves, strict=True):
        object.__setattr__(law, name, leaf)
    return law


jax.tree_util.register_pytree_node(
    Spline, lambda law: ((law.times, law.values, law.coefficients), None), _from_leaves
)
