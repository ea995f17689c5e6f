"""A quantity given in rows, joined by a curve that is smooth enough for prescribed motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
from scipy.interpolate import CubicSpline

from supple.algebra import read_only
from supple.machine.laws.law_numbers import increasing_rows
from supple.machine.laws.unbounded_law import UnboundedLaw

__all__ = ["Spline"]


@dataclass(frozen=True, eq=False)
class Spline(UnboundedLaw):
    """Natural cubic spline through rows, constant before the first and after the last.

    Value, first and second derivative are continuous between the first row and the last; there the second
    derivative is zero, and the first one jumps to zero.

    times : (k,)        s, increasing, k >= 2
    values : (k, ...)   one row for each time
    Raises ModelError for rows of other shapes, NaN or infinite entries, and times that do not increase.
    """

    times: Any
    values: Any
    coefficients: Any = field(init=False, repr=False)
    """(4, k - 1, ...) of the cubic on each piece, highest power first, in the time since its first row"""

    def __post_init__(self) -> None:
        times, values = increasing_rows(self.times, self.values)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "coefficients", read_only(CubicSpline(times, values, bc_type="natural").c))

    def __call__(self, time: Any) -> Any:
        """The value at a time."""
        starts = jnp.asarray(self.times)[:-1]
        t = jnp.clip(time, self.times[0], self.times[-1])
        piece = jnp.clip(jnp.searchsorted(starts, t, side="right") - 1, 0, len(starts) - 1)
        return jnp.polyval(jnp.asarray(self.coefficients)[:, piece], t - starts[piece])


def _leaves(law: Spline) -> tuple[tuple[Any, Any, Any], None]:
    return (law.times, law.values, law.coefficients), None


def _from_leaves(_: None, leaves: Any) -> Spline:
    # Past `__post_init__`: the coefficients of traced rows are leaves of their own, never computed anew.
    law = object.__new__(Spline)
    for name, leaf in zip(("times", "values", "coefficients"), leaves, strict=True):
        object.__setattr__(law, name, leaf)
    return law


jax.tree_util.register_pytree_node(Spline, _leaves, _from_leaves)
