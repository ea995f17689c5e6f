"""Velocities and accelerations of the nodes of a flexible body in space."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import BodyForm, Interface, node_displacements
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
    shapes = motion.coordinates, motion.coordinate_rates, motion.coordinate_accelerations
    displacement, rate, second = (node_displacements(body, each, numbers) for each in shapes)
    moving = _in_space(motion, body.nodes[numbers] + displacement, rate, second)
    return moving._replace(position=body.positions(motion, numbers))


def moving_point(interface: Interface, motion: FloatingMotion) -> NodeMotion:
    """Motion (t, 3) of an interface of a body: as `node_motion`, of its virtual node."""
    shapes = motion.coordinates, motion.coordinate_rates, motion.coordinate_accelerations
    displacement, rate, second = ((q @ interface.motion.T)[:, None, :3] for q in shapes)
    moving = _in_space(motion, interface.position + displacement, rate, second)
    return NodeMotion(*(each[:, 0] for each in moving))


def _in_space(motion: FloatingMotion, place: Array, rate: Array, second: Array) -> NodeMotion:
    """Of points (t, k, 3) of the frame, with their rates there."""
    w, dw = motion.angular_velocity[:, None], motion.angular_acceleration[:, None]
    turning = np.cross(w, place)
    velocity = turning + rate
    acceleration = np.cross(dw, place) + np.cross(w, turning) + 2 * np.cross(w, rate) + second

    def turned(vectors: Array) -> Array:
        return np.einsum("tij,tkj->tki", motion.rotation, vectors)

    return NodeMotion(
        motion.position[:, None] + turned(place),
        motion.velocity[:, None] + turned(velocity),
        motion.acceleration[:, None] + turned(acceleration),
    )
