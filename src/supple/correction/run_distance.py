"""How far two runs of a reduced body are apart, and how far it is displaced, over all nodes and times."""

from __future__ import annotations

import numpy as np

from supple.integrate import FloatingMotion
from supple.reduction import ReducedBody

__all__ = ["largest_displacement", "largest_distance"]

_ROWS = 64
"""Output times whose nodal positions are held at once."""


def largest_distance(
    body: ReducedBody, motion: FloatingMotion, other_body: ReducedBody, other_motion: FloatingMotion
) -> float:
    """Largest RMS distance of the nodes over time, between two motions at the same output times."""
    largest = 0.0
    for rows in _blocks(motion):
        apart = body.positions(motion.at(rows)) - other_body.positions(other_motion.at(rows))
        largest = max(largest, float(np.sum(apart**2, axis=(1, 2)).max()))
    return float(np.sqrt(largest / len(body.nodes)))


def largest_displacement(body: ReducedBody, motion: FloatingMotion) -> float:
    """Largest displacement of a node over time, seen from the body's first interface, or in its frame.

    The turn of the interface against the frame is taken as small.
    """
    sizes = []
    for rows in _blocks(motion):
        displaced = body.expand(motion.coordinates[rows])
        if body.interfaces:
            base = body.interfaces[0]
            moved = motion.coordinates[rows] @ base.motion.T
            turned = np.cross(moved[:, None, 3:], body.nodes - base.position)
            displaced = displaced - moved[:, None, :3] - turned
        sizes.append(np.linalg.norm(displaced, axis=2).max())
    return float(max(sizes))


def _blocks(motion: FloatingMotion) -> list[slice]:
    return [slice(start, start + _ROWS) for start in range(0, len(motion.position), _ROWS)]
