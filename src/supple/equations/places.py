"""Positions of equal pieces of a system in its common vectors and matrices.

The positions are known when a program is compiled: adjacent pieces are read by a slice, and only other pieces
are gathered and scattered one by one. Equal bodies and equal joints are treated together, as arrays with a
leading axis. So the number of traced operations grows only with the number of different kinds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray

R = TypeVar("R")


@dataclass(frozen=True)
class Places:
    """The starts of k pieces of one size in a vector."""

    starts: tuple[int, ...]
    size: int

    @property
    def number(self) -> int:
        """Number k of pieces."""
        return len(self.starts)

    @property
    def adjacent(self) -> bool:
        """Whether the pieces are contiguous."""
        first = self.starts[0]
        return self.starts == tuple(first + self.size * i for i in range(len(self.starts)))

    @property
    def span(self) -> slice:
        """From the first to the last piece, for contiguous pieces."""
        return slice(self.starts[0], self.starts[0] + self.size * self.number)

    @property
    def index(self) -> np.ndarray:
        """Positions (k, size) of all entries."""
        return np.array(self.starts)[:, None] + np.arange(self.size)

    def take(self, vector: AnyArray) -> AnyArray:
        """The pieces of a vector (n, ...), as (k, size, ...)."""
        rest = vector.shape[1:]
        if self.adjacent:
            return vector[self.span].reshape(self.number, self.size, *rest)
        first, stride = self.starts[0], self.starts[1] - self.starts[0]
        end = first + stride * self.number
        if stride > self.size and end <= len(vector) and self.starts == tuple(range(first, end, stride)):
            return vector[first:end].reshape(self.number, stride, *rest)[:, : self.size]
        return vector[self.index]


def over(function: Callable[..., R], *arguments: Any) -> R:
    """The function applied to every member of a group; arguments and result have a leading axis.

    A single member is computed without vectorisation, as if there were no groups. An array with a leading
    axis of one is shared by all members: products with it become matrix products.
    """
    leaves, structure = jax.tree.flatten(arguments)
    shared = [leaf.shape[0] == 1 for leaf in leaves]
    # A machine may be a constant of a program, but differentiation rules require JAX arrays.
    own = [leaf[0] if once else jnp.asarray(leaf) for leaf, once in zip(leaves, shared, strict=True)]

    # Mapped over leaves: a time law with axes in place of its numbers would fail its check.
    def of_leaves(each: list[AnyArray]) -> R:
        return function(*structure.unflatten(each))

    if all(shared):
        return jax.tree.map(lambda leaf: jnp.asarray(leaf)[None], of_leaves(own))
    return jax.vmap(of_leaves, in_axes=([None if once else 0 for once in shared],))(own)


def member(stacked: R, number: int = 0) -> R:
    """One member of a group: the arrays without their leading axis."""
    return jax.tree.map(lambda leaf: jnp.asarray(leaf)[number], stacked)


def assembled_vector(n: int, parts: Iterable[tuple[Places, AnyArray]]) -> jax.Array:
    """The vector (n,) from contributions (k, size) at places, which may overlap."""
    parts = [(places, values) for places, values in parts if places.size]
    if parts and _is_partition(n, [places for places, _ in parts]):
        return jnp.concatenate([values.reshape(-1) for _, values in parts])
    total = jnp.zeros(n)
    for places, values in parts:
        if places.adjacent and places.number * places.size == n:
            total = total + values.reshape(-1)
        elif places.adjacent:
            total = total.at[places.span].add(values.reshape(-1))
        else:
            total = total.at[places.index].add(values)
    return total


def _is_partition(n: int, parts: Sequence[Places]) -> bool:
    """Whether contiguous pieces cover a vector in order."""
    reached = 0
    for places in parts:
        if not places.adjacent or places.starts[0] != reached:
            return False
        reached = places.span.stop
    return reached == n


@dataclass(frozen=True)
class MatrixBlock:
    """Contributions (k, rows, columns) to a matrix."""

    rows: Places
    columns: Places
    values: AnyArray


_WINDOWS = jax.lax.ScatterDimensionNumbers(
    update_window_dims=(1, 2), inserted_window_dims=(), scatter_dims_to_operand_dims=(0, 1)
)


def assembled_matrix(shape: tuple[int, int], blocks: Iterable[MatrixBlock]) -> jax.Array:
    """The matrix from contributions, which may overlap."""
    total: jax.Array | None = None
    for block in blocks:
        rows, columns, values = block.rows, block.columns, block.values
        if not (rows.size and columns.size):
            continue
        if rows.number == 1 and (rows.size, columns.size) == shape:
            total = values[0] if total is None else total + values[0]
            continue
        total = jnp.zeros(shape) if total is None else total
        if rows.number == 1:
            total = total.at[rows.span, columns.span].add(values[0])
        else:
            starts = np.column_stack([rows.starts, columns.starts]).astype(np.int32)
            total = jax.lax.scatter_add(
                total, starts, values, _WINDOWS, mode=jax.lax.GatherScatterMode.PROMISE_IN_BOUNDS
            )
    return jnp.zeros(shape) if total is None else total
