"""Velocities and accelerations of the nodes of a flexible body in space."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import BodyForm, node_displacements
from supple.integrate.motion import FloatingMotion

Array = NDArray[np.float64]


class NodeMotion(NamedTuple):
    """Positions, velocities and accelerations (t, k, 3) of k nodes, global components."""

    position: Array
    velocity: Array
    acceleration: Array


def node_motion(body: BodyForm, motion: FloatingMotion, nodes: ArrayLike) -> NodeMotion:
    """Motion of some nodes of a body in its floating frame:

        r = R + A (x + u),   dr = dR + A (w x (x + u) + du)
        ddr = ddR + A (dw x (x + u) + w x (w x (x + u)) + 2 w x du + ddu)

    Parameters
    ----------
    body : BodyForm             motion : its part of a solution, of t times
    nodes : node numbers (k,)

    Raises
    ------
    ModelError  a node number outside the body
    """
    numbers = np.atleast_1d(np.asarray(nodes))
    place = body.nodes[numbers] + node_displacements(body, motion.coordinates, numbers)
    rate = node_displacements(body, motion.coordinate_rates, numbers)
    second = node_displacements(body, motion.coordinate_accelerations, numbers)
    w, dw = motion.angular_velocity[:, None], motion.angular_acceleration[:, None]
    turning = np.cross(w, place)
    velocity = turning + rate
    acceleration = np.cross(dw, place) + np.cross(w, turning) + 2 * np.cross(w, rate) + second

    def in_space(vectors: Array) -> Array:
        return np.einsum("tij,tkj->tki", motion.rotation, vectors)

    return NodeMotion(
        body.positions(motion, numbers),
        motion.velocity[:, None] + in_space(velocity),
        motion.acceleration[:, None] + in_space(acceleration),
    )
