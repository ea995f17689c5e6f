"""Internal force of a reduced body from packed symmetric tensors, compiled.

With `m2 = (g_k g_l)_{k <= l}` the packed products of the coordinates,

    A3 = unpack(cubic g),   A4 = unpack(quartic m2)
    K_t = K + A3 + A4,      f = K g + A3 g / 2 + A4 g / 3

so that force and tangent need one pass over the quartic matrix without its zero blocks
(`PairBlocks`). Source: [Wu2019] (49), packed.
"""

from __future__ import annotations

from functools import partial
from typing import Any, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax.custom_derivatives import SymbolicZero

from supple.reduction.pair_blocks import PairBlocks

Quartic: TypeAlias = jax.Array | PairBlocks
"""The matrix (n2, n2) of packed pairs, or its blocks."""


def _unpacked(cubic: jax.Array, quartic: Quartic, coordinates: jax.Array) -> tuple[jax.Array, jax.Array]:
    """`A3` and `A4`, (r, r) each."""
    r = coordinates.shape[0]
    rows, columns = np.triu_indices(r)
    position = np.zeros((r, r), dtype=np.int32)
    position[rows, columns] = position[columns, rows] = np.arange(rows.size)
    third = (cubic @ coordinates)[position]
    if not isinstance(quartic, PairBlocks):
        return third, (quartic @ (coordinates[rows] * coordinates[columns]))[position]
    products = [
        matrix @ (coordinates[first] * coordinates[second])
        for first, second, matrix in zip(quartic.first, quartic.second, quartic.matrices, strict=True)
    ]
    return third, jnp.concatenate([*products, jnp.zeros(1)])[quartic.position]


def polynomial_force(
    stiffness: jax.Array, cubic: jax.Array | None, quartic: Quartic | None, coordinates: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Force (r,) and tangent (r, r); linear where the body has no tensors (`cubic` is None)."""
    if cubic is None or quartic is None:
        return stiffness @ coordinates, stiffness
    return _force_and_tangent(stiffness, cubic, quartic, coordinates)


@jax.custom_jvp
def _force_and_tangent(
    stiffness: jax.Array, cubic: jax.Array, quartic: Quartic, coordinates: jax.Array
) -> tuple[jax.Array, jax.Array]:
    third, fourth = _unpacked(cubic, quartic, coordinates)
    force = (stiffness + third / 2 + fourth / 3) @ coordinates
    return force, stiffness + third + fourth


@partial(_force_and_tangent.defjvp, symbolic_zeros=True)
def _(primals: Any, tangents: Any) -> Any:
    """`df = K_t dg`, without another pass over the tensors; changes of the tensors are added."""
    *tensors, coordinates = primals
    *tensor_changes, change = jax.tree.map(_instantiated, tangents, primals, is_leaf=_is_zero)
    found = _force_and_tangent(*primals)
    (third, fourth), turned = (
        jax.jvp(lambda own: _unpacked(*tensors[1:], own), (coordinates,), (change,))[1],
        found[1] @ change,
    )
    by_coordinates = turned, third + fourth
    if all(_is_zero(leaf) for leaf in jax.tree.leaves(tangents[:3], is_leaf=_is_zero)):
        return found, by_coordinates
    # Force and tangent are linear in the tensors.
    by_tensors = _force_and_tangent(*_with_changes(tensors, tensor_changes), coordinates)
    return found, jax.tree.map(jnp.add, by_coordinates, by_tensors)


def _is_zero(tangent: Any) -> bool:
    return isinstance(tangent, SymbolicZero)


def _instantiated(tangent: Any, primal: Any) -> Any:
    return jnp.zeros_like(primal) if _is_zero(tangent) else tangent


def _with_changes(tensors: Any, changes: Any) -> Any:
    """The tensors with their numbers replaced by changes, in the same layout."""

    def is_number(leaf: Any) -> bool:
        return jnp.issubdtype(jnp.asarray(leaf).dtype, jnp.floating)

    return jax.tree.map(lambda own, change: change if is_number(own) else own, tensors, changes)


def polynomial_damping(
    damping: jax.Array, cubic: jax.Array | None, quartic: Quartic | None, coordinates: jax.Array
) -> jax.Array:
    """D(g) (r, r); constant `damping` without strain-rate damping."""
    if cubic is None or quartic is None:
        return damping
    third, fourth = _unpacked(cubic, quartic, coordinates)
    return damping + third + fourth


def polynomial_energy(
    stiffness: jax.Array, cubic: jax.Array | None, quartic: Quartic | None, coordinates: jax.Array
) -> jax.Array:
    """Strain energy `g K g / 2 + g A3 g / 6 + g A4 g / 12`."""
    energy = coordinates @ stiffness @ coordinates / 2
    if cubic is None or quartic is None:
        return energy
    third, fourth = _unpacked(cubic, quartic, coordinates)
    return energy + jnp.einsum("i,ij,j->", coordinates, third / 6 + fourth / 12, coordinates)
