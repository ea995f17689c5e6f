"""Tensors of 3 x 3 components, each an array over points, for constitutive laws.

A tensor is a nested tuple t[i][j] of arrays of one shape. A law written by components compiles to one loop
over points, without stores between its operations. Small products of arrays of shape (.., 3, 3) would be
several times slower.
"""

from __future__ import annotations

from collections.abc import Callable

import jax.numpy as jnp
from jax import Array

Tensor = tuple[tuple[Array, Array, Array], tuple[Array, Array, Array], tuple[Array, Array, Array]]


def tensor(component: Callable[[int, int], Array]) -> Tensor:
    """Tensor from a function of the two indices."""
    return tuple(tuple(component(i, j) for j in range(3)) for i in range(3))  # ty: ignore[invalid-explicit-return] - of length 3


def transposed(a: Tensor) -> Tensor:
    """a^T."""
    return tensor(lambda i, j: a[j][i])


def added(a: Tensor, b: Tensor) -> Tensor:
    """Sum a + b."""
    return tensor(lambda i, j: a[i][j] + b[i][j])


def scaled(factor: Array | float, a: Tensor) -> Tensor:
    """Product of a number and a tensor."""
    return tensor(lambda i, j: factor * a[i][j])


def product(a: Tensor, b: Tensor) -> Tensor:
    """Product a b."""
    return tensor(lambda i, j: a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j])


def symmetric_part(a: Tensor) -> Tensor:
    """(a + a^T) / 2."""
    return tensor(lambda i, j: a[i][i] if i == j else 0.5 * (a[i][j] + a[j][i]))


def deviator(a: Tensor) -> tuple[Array, Tensor]:
    """Mean of the diagonal, and a without it."""
    mean = (a[0][0] + a[1][1] + a[2][2]) / 3
    return mean, tensor(lambda i, j: a[i][j] - mean if i == j else a[i][j])


def double_dot(a: Tensor, b: Tensor) -> Array:
    """Double contraction a : b."""
    total = a[0][0] * b[0][0]
    for i, j in [(0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)]:
        total = total + a[i][j] * b[i][j]
    return total


def cofactor(a: Tensor) -> Tensor:
    """Cofactor det(a) a^-T."""

    def minor(i: int, j: int) -> Array:
        r, s, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
        return a[r][c] * a[s][d] - a[r][d] * a[s][c]

    return tensor(minor)


def determinant(a: Tensor, cof: Tensor) -> Array:
    """Determinant, from the first row and the cofactor."""
    return a[0][0] * cof[0][0] + a[0][1] * cof[0][1] + a[0][2] * cof[0][2]


def as_array(a: Tensor) -> Array:
    """Array (3, 3, ...) of the components."""
    return jnp.stack([jnp.stack(row) for row in a])
