"""Kinematics of a floating frame: positions in space from the frame's motion and the body's deformation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arrays import FloatArray
from supple.body.interface import Interface
from supple.errors import ModelError
from supple.integrate.motion import FloatingMotion

__all__ = ["floating_positions", "in_space", "node_displacements"]

# Largest number of displacement values in memory at a time (32 MiB), unless one time needs more. All times of
# a long run may not fit in memory.
_FIELD_NUMBERS = 2**22


class Deforming(Protocol):
    """Members of `BodyForm` that the kinematics need."""

    @property
    def nodes(self) -> np.ndarray:
        """Undeformed positions (N, 3) of the nodes, or of a rigid body's interfaces, in its frame, m."""
        ...

    def interface(self, name: str) -> Interface:
        """The interface of that name; the ModelError for an unknown name lists the nearest name, or all."""
        ...

    def expand(self, coordinates: np.ndarray, nodes: NDArray[np.intp] | slice = ..., /) -> np.ndarray:
        """Displacements (..., k, 3) of all or some nodes for coordinates (..., r), in the body's frame.

        The displacements are at most quadratic in the coordinates.
        """
        ...

    def expand_rates(
        self, coordinates: np.ndarray, rates: np.ndarray, nodes: NDArray[np.intp] | slice = ..., /
    ) -> np.ndarray:
        """Displacement rates (..., k, 3) at coordinates and rates (..., r); linear in the rates."""
        ...


def in_space(position: FloatArray, rotation: FloatArray, local: FloatArray) -> FloatArray:
    """Positions r = R + A y (t, k, 3) of points y in a moving frame.

    position, rotation : (t, 3) and (t, 3, 3)    R of the frame's origin, A from the frame to space
    local : (t, k, 3)    y in the frame; (1, k, 3) for fixed points
    """
    # The product uses BLAS and takes a sixth of the time of an einsum.
    return position[:, None] + local @ np.ascontiguousarray(np.swapaxes(rotation, 1, 2))


def floating_positions(
    body: Deforming, motion: FloatingMotion, nodes: ArrayLike | slice = slice(None)
) -> FloatArray:
    """Positions r = R + A (x + u) (t, k, 3) of some nodes (k,), or all, in space.

    Raises ModelError for a node number outside the body.
    Source: [Wu2019] (1)
    """
    local = body.nodes[_chosen(body, nodes)] + node_displacements(body, motion.coordinates, nodes)
    return in_space(motion.position, motion.rotation, local)


def node_displacements(
    body: Deforming, coordinates: FloatArray, nodes: ArrayLike | slice = slice(None)
) -> FloatArray:
    """Displacements u (t, k, 3) of some nodes (k,), or all, in the body's frame, at coordinates (t, r).

    Raises ModelError for a node number outside the body.
    """
    chosen = _chosen(body, nodes)
    return np.concatenate(
        [body.expand(coordinates[rows], chosen) for rows in time_slices(body, len(coordinates))]
    )


def time_slices(body: Deforming, n_times: int) -> Iterator[slice]:
    """Ranges of output times, each with at most _FIELD_NUMBERS displacement values of all nodes."""
    n_rows = max(1, _FIELD_NUMBERS // max(1, body.nodes.size))
    return (slice(start, start + n_rows) for start in range(0, max(n_times, 1), n_rows))


def _chosen(body: Deforming, nodes: ArrayLike | slice) -> NDArray[np.int64] | slice:
    if isinstance(nodes, slice):
        return nodes
    return checked_nodes(nodes, len(body.nodes))


def checked_nodes(nodes: ArrayLike, n_nodes: int) -> NDArray[np.int64]:
    """Node numbers (k,) as an integer array; ModelError for a number outside 0 to n_nodes - 1."""
    numbers = np.atleast_1d(np.asarray(nodes, dtype=np.int64))
    if numbers.size and not (0 <= numbers.min() and numbers.max() < n_nodes):
        raise ModelError(
            f"recovery: node numbers {numbers.min()} to {numbers.max()}; the body has {n_nodes} nodes, from 0"
        )
    return numbers
