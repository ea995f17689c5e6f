"""Tables over one or two variables: linear interpolation, constant beyond the ends of a table.

The derivative at a row is that of the interval after it, and at the last row that of the interval before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike

from supple.arguments import check_numbers
from supple.errors import ModelError

__all__ = ["Curve", "Surface"]


@dataclass(frozen=True)
class Curve:
    """`z(x)` through the rows of a table, linear between the rows, constant beyond the first and last row.

    x : (n,) ascending      z : (n,)
    Raises ModelError for another shape, numbers that are not finite, and x that does not ascend.
    """

    x: Any
    z: Any

    def __post_init__(self) -> None:
        _freeze(self, "x", "z")
        _check_ascending("a curve", self.x)
        if np.shape(self.z) != np.shape(self.x):
            raise ModelError(f"a curve has {len(self.x)} points, and values of shape {np.shape(self.z)}")

    @property
    def parameters(self) -> tuple[np.ndarray, ...]:
        """The table as arrays."""
        return (np.array(self.x), np.array(self.z))

    def __call__(self, x: ArrayLike) -> jax.Array:
        """The value at x."""
        return curve_at(x, self.parameters)


@dataclass(frozen=True)
class Surface:
    """`z(x, y)` through a table, bilinear between rows and columns, constant normal to the edges beyond them.

    x : (n,) ascending      y : (m,) ascending      z : (n, m)
    Raises ModelError for another shape, numbers that are not finite, and x or y that does not ascend.
    """

    x: Any
    y: Any
    z: Any

    def __post_init__(self) -> None:
        _freeze(self, "x", "y", "z")
        _check_ascending("the rows of a surface", self.x)
        _check_ascending("the columns of a surface", self.y)
        if np.shape(self.z) != (len(self.x), len(self.y)):
            raise ModelError(
                f"a surface has {len(self.x)} rows and {len(self.y)} columns, and values of shape "
                f"{np.shape(self.z)}"
            )

    @property
    def parameters(self) -> tuple[np.ndarray, ...]:
        """The table as arrays."""
        return (np.array(self.x), np.array(self.y), np.array(self.z))

    def __call__(self, x: ArrayLike, y: ArrayLike) -> jax.Array:
        """The value at x and y."""
        return surface_at(x, y, self.parameters)


def curve_at(x: ArrayLike, parameters: Sequence[ArrayLike]) -> jax.Array:
    """The value at x of a curve with the parameters x (n,) and z (n, ...)."""
    places, values = map(jnp.asarray, parameters)
    row, share = _interval(x, places)
    return (1 - share) * values[row] + share * values[row + 1]


def surface_at(x: ArrayLike, y: ArrayLike, parameters: Sequence[ArrayLike]) -> jax.Array:
    """The value at x and y of a surface with the parameters x (n,), y (m,) and z (n, m)."""
    rows, columns, values = map(jnp.asarray, parameters)
    (row, down), (column, across) = _interval(x, rows), _interval(y, columns)
    upper = (1 - across) * values[row, column] + across * values[row, column + 1]
    lower = (1 - across) * values[row + 1, column] + across * values[row + 1, column + 1]
    return (1 - down) * upper + down * lower


def _interval(x: ArrayLike, places: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Number of the row before x, and the fraction, 0 to 1, of the interval from this row to the next."""
    row = jnp.clip(jnp.searchsorted(places, x, side="right") - 1, 0, len(places) - 2)
    share = (x - places[row]) / (places[row + 1] - places[row])
    # Not jnp.clip: its derivative at a row is half of that of the interval.
    return row, jnp.where(share < 0, 0.0, jnp.where(share > 1, 1.0, share))


def _freeze(table: Any, *names: str) -> None:
    # Arrays are stored as tuples, so that force elements with equal tables compare equal.
    for name in names:
        check_numbers(f"{type(table).__name__}, {name}", getattr(table, name))
        array = np.asarray(getattr(table, name), dtype=float)
        if not np.isfinite(array).all():
            raise ModelError(f"{type(table).__name__}, {name}: every number must be finite")
        object.__setattr__(table, name, _tuples(array.tolist()))


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _check_ascending(what: str, places: Any) -> None:
    if np.ndim(places) != 1 or len(places) < 2 or not (np.diff(places) > 0).all():
        raise ModelError(f"{what} must be two or more ascending numbers, got {places}")
