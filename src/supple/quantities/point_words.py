"""A node in words: its id and where it lies undeformed."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["point_words"]


def point_words(node: int, point: ArrayLike) -> str:
    """Such as "node 17 at (0.5, 0, 0.01)", in mesh axes."""
    return f"node {node} at ({', '.join(f'{x:.4g}' for x in np.asarray(point))})"
