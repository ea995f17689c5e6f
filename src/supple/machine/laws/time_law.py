"""Quantities given as functions of time: prescribed motions, forces, torques.

A law is a JAX pytree, so that the numbers in it can differ between the load cases of one compiled batch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ModelError

__all__ = ["Constant", "Table", "TimeFunction", "TimeLaw", "Turning", "as_time_law", "check_law_shape"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Constant:
    """The same value at all times."""

    value: Any

    def __call__(self, time: Any) -> Any:  # noqa: ARG002 - a law is called with the time, needed or not
        """The value."""
        return self.value

    @property
    def begin(self) -> float:
        """First time at which the law is defined."""
        return float("-inf")

    @property
    def end(self) -> float:
        """Last time at which the law is defined."""
        return float("inf")


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Table:
    """Linear interpolation between rows: `times` (k,) ascending, `values` (k, ...)."""

    times: Any
    values: Any

    def __post_init__(self) -> None:
        if not all(isinstance(item, (np.ndarray, list, tuple)) for item in (self.times, self.values)):
            return  # inside a JAX transformation the leaves are tracers (or placeholders): nothing to check
        times = np.asarray(self.times, dtype=float)
        values = np.asarray(self.values, dtype=float)
        if times.ndim != 1 or times.size < 2 or len(values) != times.size:
            raise ValueError(
                f"a table needs at least two times and one row of values for each, got times of shape "
                f"{times.shape} and values of shape {values.shape}"
            )
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise ValueError("a table of a quantity over time holds NaN or infinite entries")
        if (np.diff(times) <= 0).any():
            row = int(np.argmax(np.diff(times) <= 0)) + 1
            raise ValueError(
                f"times of a table must increase: row {row} has {times[row]} after {times[row - 1]}"
            )
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    def __call__(self, time: Any) -> Any:
        """The value at a time, between the rows around it."""
        upper = jnp.clip(jnp.searchsorted(self.times, time, side="right"), 1, len(self.times) - 1)
        t0, t1 = jnp.asarray(self.times)[upper - 1], jnp.asarray(self.times)[upper]
        v0, v1 = jnp.asarray(self.values)[upper - 1], jnp.asarray(self.values)[upper]
        return v0 + (v1 - v0) * ((time - t0) / (t1 - t0))

    @property
    def begin(self) -> float:
        """First time at which the law is defined."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """Last time at which the law is defined."""
        return float(self.times[-1])


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class TimeFunction:
    """A function of time written with `jax.numpy`; it must be smooth enough for the motion wanted."""

    function: Callable[[Any], Any] = field(metadata={"static": True})

    def __call__(self, time: Any) -> Any:
        """The function's value."""
        return self.function(time)

    @property
    def begin(self) -> float:
        """First time at which the law is defined."""
        return float("-inf")

    @property
    def end(self) -> float:
        """Last time at which the law is defined."""
        return float("inf")


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Turning:
    """Vectors given in axes that turn: v(t) = R(axis, angle(t)) vectors(t), R by Rodrigues' formula.

    vectors : a law of (..., 3), in the turning axes
    axis : (3,) unit vector
    angle : a law, or a function of time, rad

    Exact between the rows of a table, where a table of the turned vectors would cut corners.
    """

    vectors: Any
    axis: Any
    angle: Any

    def __post_init__(self) -> None:
        if not isinstance(self.axis, (np.ndarray, list, tuple)):
            return  # a tracer: see Table
        axis = np.asarray(self.axis, dtype=float)
        if axis.shape != (3,) or not abs(np.linalg.norm(axis) - 1) < 1e-9:
            raise ValueError(f"the axis of turning vectors must be a unit vector, got {self.axis}")
        object.__setattr__(self, "axis", axis)
        object.__setattr__(self, "vectors", as_time_law(self.vectors))
        object.__setattr__(self, "angle", as_time_law(self.angle))

    def __call__(self, time: Any) -> Any:
        """The vectors at a time, in the axes that do not turn."""
        v, a, angle = jnp.asarray(self.vectors(time)), jnp.asarray(self.axis), self.angle(time)
        along = (v @ a)[..., None] * a
        return along + jnp.cos(angle) * (v - along) + jnp.sin(angle) * jnp.cross(a, v)

    @property
    def begin(self) -> float:
        """First time at which the law is defined."""
        return max(self.vectors.begin, self.angle.begin)

    @property
    def end(self) -> float:
        """Last time at which the law is defined."""
        return min(self.vectors.end, self.angle.end)


TimeLaw = Constant | Table | TimeFunction | Turning
"""A value, or an array of them, over time: `law(time)`, defined from `law.begin` to `law.end`."""


def as_time_law(value: Any) -> TimeLaw:
    """The law meant by a law, a function of time, a number or an array."""
    if isinstance(value, (Constant, Table, TimeFunction, Turning)):
        return value
    if callable(value):
        return TimeFunction(value)
    array = np.asarray(value, dtype=float)
    if not np.isfinite(array).all():
        raise ValueError(f"a constant quantity holds NaN or infinite entries: {array}")
    return Constant(array)


def check_law_shape(what: str, law: TimeLaw, *shapes: tuple[int, ...]) -> None:
    """Raise ModelError unless the law's values have one of the shapes, and JAX can trace it."""
    try:
        shape = jax.eval_shape(lambda time: jnp.asarray(law(time)), jnp.zeros(())).shape
    except jax.errors.TracerArrayConversionError as error:
        raise ModelError(f"{what}: its function of time must be written with jax.numpy, not numpy") from error
    if shape not in shapes:
        wanted = " or ".join(map(str, shapes))
        raise ModelError(f"{what}: its values over time have shape {shape}; they must have {wanted}")
