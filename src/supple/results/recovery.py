"""From coordinates back to the motion of the nodes, in the body's frame and in space."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.errors import ModelError
from supple.integrate.solution import FloatingMotion

Array = NDArray[np.float64]

# Numbers of the displacement field held at a time (32 MiB), for a long run of a large body would not fit.
_FIELD_NUMBERS = 2**22


class ElasticBody(Protocol):
    """What recovery needs of a body, reduced or full: its nodes, and what their coordinates displace."""

    @property
    def nodes(self) -> np.ndarray:
        """Undeformed positions (N, 3) in the body's frame."""
        ...

    def expand(self, gamma: np.ndarray, /) -> np.ndarray:
        """Nodal displacements (..., N, 3) of the coordinates (..., r), in the body's frame."""
        ...


def node_displacements(
    body: ElasticBody, coordinates: Array, nodes: ArrayLike | slice = slice(None)
) -> Array:
    """Displacements u = V gamma of some nodes, or all, in the body's frame.

    Parameters
    ----------
    coordinates : array (t, r)
    nodes : node numbers (k,), all by default

    Returns
    -------
    array (t, k, 3)

    Raises
    ------
    ModelError  a node number outside the body
    """
    chosen = _chosen(body, nodes)
    return np.concatenate(
        [body.expand(coordinates[rows])[:, chosen] for rows in time_slices(body, len(coordinates))]
    )


def node_positions(
    body: ElasticBody, motion: FloatingMotion, nodes: ArrayLike | slice = slice(None)
) -> Array:
    """Positions r = R + A (x + u) of some nodes, or all, in space.

    Parameters and errors as for node_displacements, the coordinates being those of the motion.

    Returns
    -------
    array (t, k, 3)
    Source: [Wu2019] (1)
    """
    local = body.nodes[_chosen(body, nodes)] + node_displacements(body, motion.coordinates, nodes)
    return motion.position[:, None] + np.einsum("tij,tkj->tki", motion.rotation, local)


def displacement_from_axes(positions: Array, origin: ArrayLike, rotation: Array, rest: ArrayLike) -> Array:
    """Displacement A^T (r - R) - q_0 of a point against moving axes, as an observer on them sees it.

    The tip displacement of [Wu2019] (51) is the tip's against the axes of the driven root, in whichever
    floating frame the body was computed.

    Parameters
    ----------
    positions : array (t, 3)      r, in space
    origin : array (3,) or (t, 3)  R
    rotation : array (t, 3, 3)    A, axes to space
    rest : array (3,)             q_0, where the undeformed point lies in the axes

    Returns
    -------
    array (t, 3)
    """
    return np.einsum("tji,tj->ti", rotation, positions - np.asarray(origin)) - np.asarray(rest)


def time_slices(body: ElasticBody, n_times: int) -> Iterator[slice]:
    """Ranges of output times whose full displacement fields fit in memory together."""
    n_rows = max(1, _FIELD_NUMBERS // body.nodes.size)
    return (slice(start, start + n_rows) for start in range(0, max(n_times, 1), n_rows))


def _chosen(body: ElasticBody, nodes: ArrayLike | slice) -> NDArray[np.int64] | slice:
    if isinstance(nodes, slice):
        return nodes
    return node_numbers(nodes, len(body.nodes))


def node_numbers(nodes: ArrayLike, n_nodes: int) -> NDArray[np.int64]:
    """Node numbers (k,) from 0; ModelError where one is outside a body of n_nodes."""
    numbers = np.atleast_1d(np.asarray(nodes, dtype=np.int64))
    if numbers.size and not (0 <= numbers.min() and numbers.max() < n_nodes):
        raise ModelError(
            f"recovery: node numbers {numbers.min()} to {numbers.max()} in a body of {n_nodes} nodes"
        )
    return numbers
