"""Initial positions and velocities of the nodes of a placed part."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray
from supple.machine import Placed


def undeformed(placed: Placed) -> FloatArray:
    """Positions (N, 3) in space of its undeformed nodes."""
    return placed.position + placed.body.nodes @ placed.rotation.T


def rigid_velocities(placed: Placed, points: FloatArray) -> FloatArray:
    """Initial velocities (n, 3) of points (n, 3) in space that move with its frame."""
    velocity, turning = np.split(placed.twist, 2)
    return velocity + np.cross(placed.rotation @ turning, points - placed.position)
