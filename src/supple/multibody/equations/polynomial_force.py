"""Internal force of a reduced body from packed symmetric tensors, compiled.

With `m2 = (g_k g_l)_{k <= l}` the packed products of the coordinates,

    A3 = unpack(cubic g),   A4 = unpack(quartic m2)
    K_t = K + A3 + A4,      f = K g + A3 g / 2 + A4 g / 3

so that force and tangent cost one pass over the quartic matrix. Source: [Wu2019] (49), packed.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

__all__ = ["polynomial_damping", "polynomial_energy", "polynomial_force"]


def _packing(r: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row and column of each packed pair, and the (r, r) table of packed positions."""
    rows, columns = np.triu_indices(r)
    position = np.zeros((r, r), dtype=np.int32)
    position[rows, columns] = np.arange(rows.size)
    position[columns, rows] = np.arange(rows.size)
    return rows, columns, position


def polynomial_force(
    stiffness: jax.Array, cubic: jax.Array | None, quartic: jax.Array | None, coordinates: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Force (r,) and tangent (r, r); linear where the body has no tensors (`cubic` is None)."""
    if cubic is None or quartic is None:
        return stiffness @ coordinates, stiffness
    rows, columns, position = _packing(coordinates.shape[0])
    third = (cubic @ coordinates)[position]
    fourth = (quartic @ (coordinates[rows] * coordinates[columns]))[position]
    force = (stiffness + third / 2 + fourth / 3) @ coordinates
    return force, stiffness + third + fourth


def polynomial_damping(
    damping: jax.Array, cubic: jax.Array | None, quartic: jax.Array | None, coordinates: jax.Array
) -> jax.Array:
    """D(g) (r, r) of damping that follows the strain rate; `damping` itself where it does not."""
    if cubic is None or quartic is None:
        return damping
    rows, columns, position = _packing(coordinates.shape[0])
    gained = cubic @ coordinates + quartic @ (coordinates[rows] * coordinates[columns])
    return damping + gained[position]


def polynomial_energy(
    stiffness: jax.Array, cubic: jax.Array | None, quartic: jax.Array | None, coordinates: jax.Array
) -> jax.Array:
    """Strain energy `g K g / 2 + g A3 g / 6 + g A4 g / 12`."""
    energy = coordinates @ stiffness @ coordinates / 2
    if cubic is None or quartic is None:
        return energy
    rows, columns, position = _packing(coordinates.shape[0])
    third = (cubic @ coordinates)[position]
    fourth = (quartic @ (coordinates[rows] * coordinates[columns]))[position]
    return energy + jnp.einsum("i,ij,j->", coordinates, third / 6 + fourth / 12, coordinates)
