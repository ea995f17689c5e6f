"""How far a body is displaced, over nodes and times."""

from __future__ import annotations

import numpy as np

from supple.body import BodyForm
from supple.integrate import FloatingMotion

__all__ = ["blocks_of_times", "largest_displacement"]

_ROWS = 64
"""Output times whose nodal positions are held at once."""


def largest_displacement(
    body: BodyForm, motion: FloatingMotion, nodes: np.ndarray | slice = slice(None)
) -> float:
    """Largest displacement of a node over time, seen from the body's first interface, or in its frame.

    nodes : those looked at
    The turn of the interface against the frame is taken as small.
    """
    sizes = []
    for rows in blocks_of_times(len(motion.position)):
        displaced = body.expand(motion.coordinates[rows])[:, nodes]
        if body.interfaces:
            base = body.interfaces[0]
            moved = motion.coordinates[rows] @ base.motion.T
            turned = np.cross(moved[:, None, 3:], body.nodes[nodes] - base.position)
            displaced = displaced - moved[:, None, :3] - turned
        sizes.append(np.linalg.norm(displaced, axis=2).max())
    return float(max(sizes))


def blocks_of_times(n: int) -> list[slice]:
    """Numbers of n output times, a few at once."""
    return [slice(start, start + _ROWS) for start in range(0, n, _ROWS)]
