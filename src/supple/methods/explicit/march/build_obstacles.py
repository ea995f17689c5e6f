"""Contacts with rigid obstacles: nodes that start inside, and the effect of free obstacles on the step limit.

A free obstacle of mass m_o and the nodes in contact vibrate on the penalty stiffnesses k_i. For any a > 0,

    (u_i - u_o)^2 <= (1 + a) u_i^2 + (1 + 1/a) u_o^2

A is the largest squared frequency of the nodes on the penalties alone, and B = sum k_i / m_o. With a = B / A,
squared frequencies of the nodes and of the obstacle are at most A + B.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from scipy.spatial import KDTree

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.machine import Contact, RigidSphere
from supple.machine.obstacles import Obstacle


def recoil(obstacle: Obstacle, points: FloatArray, stiffness: FloatArray) -> float:
    """B = sum k / m_o, 1/s^2, of the nodes that touch an obstacle at once; zero without a finite mass.

    points : (n, 3) at the start;   stiffness : (n,) k, N/m
    """
    if np.isinf(obstacle.mass):
        return 0.0
    every = float(stiffness.sum())
    if isinstance(obstacle, RigidSphere):  # Nodes inside a sphere are less than two radii apart.
        counts = KDTree(points).query_ball_point(points, 2 * obstacle.radius, return_length=True)
        every = min(every, float(counts.max() * stiffness.max()))
    return every / obstacle.mass


def check_outside(contact: Contact, points: FloatArray, part: FloatArray) -> None:
    """Raise ModelError if one of the points (n, 3) in space starts inside the obstacle of a contact.

    part : (N, 3) all nodes of the part, whose size allows for round-off of a single point
    """
    gap = np.asarray(contact.obstacle.gap(jnp.asarray(points.T))[0])
    set_size, part_size = (float(np.linalg.norm(np.ptp(each, axis=0))) for each in (points, part))
    if gap.min() < -(1e-6 * set_size + 1e-9 * part_size):
        worst = int(gap.argmin())
        raise ModelError(
            f"contact of '{contact.nodes}': the node at {np.array2string(points[worst], precision=6)} starts "
            f"{-gap[worst]:.3g} inside the {type(contact.obstacle).__name__}; move the parts apart"
        )
