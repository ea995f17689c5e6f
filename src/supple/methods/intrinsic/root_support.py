"""Supports of the root: its free twists, fixed in the root's own axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from supple.algebra import read_only
from supple.arrays import FloatArray
from supple.errors import ModelError

__all__ = ["BALL", "CLAMPED", "FREE", "RootSupport", "hinged", "sliding"]


@dataclass(frozen=True, eq=False)
class RootSupport:
    """Free motion of the root station: x_1(root) = free @ rates.

    free : (6, k)   independent twists, velocity then angular velocity, in the root's axes; k from 0 to 6
    Raises ModelError for twists of the wrong shape, or that are linearly dependent.
    """

    free: FloatArray

    def __post_init__(self) -> None:
        free = read_only(self.free)
        if free.ndim != 2 or free.shape[0] != 6:
            raise ModelError(f"the free twists of a support must be an array (6, k), not {free.shape}")
        if not np.isfinite(free).all():
            raise ModelError(f"the free twists of a support must be finite, not {free.T.tolist()}")
        if free.shape[1] and np.linalg.matrix_rank(free) < free.shape[1]:
            raise ModelError("the free twists of a support are linearly dependent: leave one out")
        object.__setattr__(self, "free", free)


CLAMPED = RootSupport(np.zeros((6, 0)))
"""The root is fixed, or has a prescribed motion."""
FREE = RootSupport(np.eye(6))
"""The root is free."""
BALL = RootSupport(np.eye(6)[:, 3:])
"""The root rotates about a fixed point."""


def hinged(axis: ArrayLike) -> RootSupport:
    """Support of a root that rotates about an axis (3,), in the root's axes; the axis is fixed in space."""
    return RootSupport(np.concatenate([np.zeros(3), _unit(axis)])[:, None])


def sliding(axis: ArrayLike) -> RootSupport:
    """Support of a root that moves along an axis (3,), in the root's axes, without rotation."""
    return RootSupport(np.concatenate([_unit(axis), np.zeros(3)])[:, None])


def _unit(axis: ArrayLike) -> FloatArray:
    direction = np.asarray(axis, dtype=np.float64)
    length = np.linalg.norm(direction)
    if direction.shape != (3,) or not np.isfinite(length) or length == 0:
        raise ModelError(f"the axis of a support must be three finite numbers, not all zero; got {axis}")
    return direction / length
