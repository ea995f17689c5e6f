"""Legs of one length for compiled programs: those of other lengths would be compiled anew."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

__all__ = ["full_leg"]


def full_leg(history: Any, length: int) -> Any:
    """A history (t, ...), or a tree of them, as long as a full leg: the last instant is repeated."""

    def filled(leaf: Any) -> np.ndarray:
        known = np.asarray(leaf)
        more = max(length - len(known), 0)
        return np.pad(known, ((0, more), *((0, 0),) * (known.ndim - 1)), mode="edge")

    return jax.tree.map(filled, history)
