"""Sum of element forces at nodes by gathering the element corners that meet at each node.

A scatter with repeated addresses is several times slower on a CPU, and its order of summation varies on a
GPU. The order here is fixed, so that a resumed run is equal in every digit.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

__all__ = ["gathered", "incidence"]


def incidence(nodes: NDArray[np.int64], n_nodes: int) -> NDArray[np.int64]:
    """Indices (m, N) into `nodes.ravel()` of the corners at each node, at most m, padded with `nodes.size`.

    nodes : (k, E) nodes of the elements
    """
    flat = nodes.ravel()
    count = np.bincount(flat, minlength=n_nodes)
    order = np.argsort(flat, kind="stable")
    rank = np.arange(flat.size) - np.repeat(np.concatenate([[0], np.cumsum(count)[:-1]]), count)
    table = np.full((count.max(initial=0), n_nodes), flat.size)
    table[rank, flat[order]] = order
    return table


def gathered(values: Array, table: Array) -> Array:
    """Sums (c, N) at the nodes of corner values (c, k, E)."""
    flat = values.reshape(len(values), -1)
    padded = jnp.concatenate([flat, jnp.zeros((len(values), 1))], axis=1)
    total = padded[:, table[0]]
    for row in range(1, len(table)):  # few rows: unrolled when the program is traced
        total = total + padded[:, table[row]]
    return total
