"""Legs of one length for compiled programs, which would be compiled again for every other length."""

from __future__ import annotations

from typing import TypeVar

import jax
import numpy as np

__all__ = ["full_leg", "n_good"]

T = TypeVar("T")


def full_leg(history: T, length: int) -> T:
    """A history (t, ...), or a tree of histories, padded to `length` instants by copies of the last one."""

    def filled(leaf: np.ndarray) -> np.ndarray:
        known = np.asarray(leaf)
        more = max(length - len(known), 0)
        return np.pad(known, ((0, more), *((0, 0),) * (known.ndim - 1)), mode="edge")

    return jax.tree.map(filled, history)


def n_good(history: object, converged: np.ndarray) -> int:
    """Number of instants (t,) of a tree of histories before the first not finite, or not converged."""
    sizes = [np.abs(leaf).reshape(len(leaf), -1).sum(axis=1) for leaf in jax.tree.leaves(history)]
    return int(np.argmin(np.append(np.isfinite(np.sum(sizes, axis=0)) & converged, False)))
