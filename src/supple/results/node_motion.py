"""Velocities and accelerations of the nodes of a flexible body in space."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import BodyForm, Interface
from supple.body.floating_kinematics import time_slices
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
    q, dq, ddq = motion.coordinates, motion.coordinate_rates, motion.coordinate_accelerations
    parts = [_of_frame(body, q[rows], dq[rows], ddq[rows], numbers) for rows in time_slices(body, len(q))]
    displacement, rate, second = (np.concatenate(each) for each in zip(*parts, strict=True))
    moving = _in_space(motion, body.nodes[numbers] + displacement, rate, second)
    return moving._replace(position=body.positions(motion, numbers))


def moving_point(interface: Interface, motion: FloatingMotion) -> NodeMotion:
    """Motion (t, 3) of an interface of a body: as `node_motion`, of its virtual node."""
    shapes = motion.coordinates, motion.coordinate_rates, motion.coordinate_accelerations
    displacement, rate, second = ((q @ interface.motion.T)[:, None, :3] for q in shapes)
    moving = _in_space(motion, interface.position + displacement, rate, second)
    return NodeMotion(*(each[:, 0] for each in moving))


def _of_frame(
    body: BodyForm, q: Array, dq: Array, ddq: Array, nodes: NDArray[np.intp]
) -> tuple[Array, Array, Array]:
    """Displacements (t, k, 3) of some nodes in the frame, and their first and second rates.

    Displacements are quadratic, u = V q + Z(q, q): expand_rates is V dq + 2 Z(q, dq), so that
    ddu = V ddq + 2 Z(q, ddq) + 2 Z(dq, dq).
    """
    quadratic = body.expand_rates(dq, dq, nodes) - body.expand_rates(np.zeros_like(dq), dq, nodes)
    rate, second = body.expand_rates(q, dq, nodes), body.expand_rates(q, ddq, nodes)
    return body.expand(q, nodes), rate, second + quadratic


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
