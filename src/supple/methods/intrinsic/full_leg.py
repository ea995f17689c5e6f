"""Legs of one length for compiled programs, which would be compiled again for every other length."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

__all__ = ["full_leg"]


def full_leg(history: Any, length: int) -> Any:
    """A history (t, ...), or a tree of histories, padded to `length` instants by copies of the last one."""

    def filled(leaf: Any) -> np.ndarray:
        known = np.asarray(leaf)
        more = max(length - len(known), 0)
        return np.pad(known, ((0, more), *((0, 0),) * (known.ndim - 1)), mode="edge")

    return jax.tree.map(filled, history)
