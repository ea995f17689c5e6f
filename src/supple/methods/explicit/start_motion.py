"""Where the nodes of a placed part stand, and how they move at the start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.machine import Placed

__all__ = ["rigid_velocities", "undeformed"]

FloatArray = NDArray[np.float64]


def undeformed(placed: Placed) -> FloatArray:
    """Positions (N, 3) in space of its nodes, undeformed."""
    return placed.position + placed.body.nodes @ placed.rotation.T


def rigid_velocities(placed: Placed, points: FloatArray) -> FloatArray:
    """Velocities (n, 3) at the start of points (n, 3) in space that move with its frame."""
    velocity, turning = np.split(placed.twist, 2)
    return velocity + np.cross(placed.rotation @ turning, points - placed.position)
