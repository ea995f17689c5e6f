"""Motion of nodes and interfaces of a body in space, for joints, sensors and animations."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray
from supple.body.floating_kinematics import (
    Deforming,
    checked_nodes,
    floating_positions,
    in_space,
    time_slices,
)
from supple.body.form_defaults import FormDefaults
from supple.body.interface import Interface, place_in_frame
from supple.body.sections import Sections, sections_of_elements
from supple.errors import ModelError
from supple.fem import FiniteElementModel
from supple.integrate.motion import FloatingMotion, Motion

__all__ = ["InterfaceMotion", "NodeMotion"]


class NodeMotion(NamedTuple):
    """Positions, velocities and accelerations (t, k, 3) of k nodes, global components."""

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray


class InterfaceMotion(NamedTuple):
    """Motion of an interface at t times, global components.

    position : (t, 3)               m
    rotation : (t, 3, 3)            columns: the mesh axes after the rotation of the interface
    velocity, acceleration : (t, 3) m/s, m/s^2
    angular_velocity : (t, 3)       rad/s
    """

    position: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    angular_velocity: FloatArray


class FloatingForm(FormDefaults):
    """Members shared by rigid, reduced and full bodies: points in a floating frame."""

    def positions(
        self: Deforming, motion: Motion, nodes: ArrayLike | slice = slice(None)
    ) -> NDArray[np.float64]:
        """Positions r = R + A (x + u) (t, k, 3) of all or some nodes in space."""
        return floating_positions(self, motion.of_type(FloatingMotion), nodes)

    def node_motion(self: Deforming, motion: Motion, nodes: ArrayLike) -> NodeMotion:
        """Positions, velocities and accelerations (t, k, 3) of some nodes in space."""
        return floating_node_motion(self, motion.of_type(FloatingMotion), nodes)

    def interface_motion(self: Deforming, motion: Motion, name: str) -> InterfaceMotion:
        """Pose, velocities and acceleration of an interface in space at t times."""
        return floating_interface_motion(self.interface(name), motion.of_type(FloatingMotion))

    def sections(self: Any, model: FiniteElementModel | None, /) -> Sections:
        """Force and moment across sections, from the elements of `model`.

        Raises ModelError for a rigid body, or for `model` None.
        """
        if not self.n_coordinates:
            return FormDefaults.sections(self, model)
        if model is None:
            raise ModelError(
                f"section forces need the elements of body '{self.name}', which are not known; give its "
                "model, or read the force of a joint or a spring"
            )
        return sections_of_elements(self, model)

    def motion_near(
        self,
        position: FloatArray,
        rotation: FloatArray,
        coordinates: FloatArray,
        displacement: FloatArray,
        rates: FloatArray,
    ) -> FloatingMotion:
        """Motion at displacements p (t, 6 + r) from a pose and coordinates, with rates p' (t, 6 + r).

        The rates are taken as velocities, which is exact at p = 0. Accelerations are zero.
        """
        frames = frames_near(position, rotation, displacement, rates)
        still, q = np.zeros_like(frames[2]), coordinates + displacement[:, 6:]
        return FloatingMotion(*frames[:2], q, *frames[2:], rates[:, 6:], still, still, np.zeros_like(q))


def frames_near(
    position: FloatArray, rotation: FloatArray, displacement: FloatArray, rates: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Positions, rotations, velocities and angular velocities of frames displaced by p = (A^T dR, psi, ..).

    dR is the displacement of the origin, psi the rotation vector in the axes of the frame.
    displacement, rates : p, p' (t, 6 + r)    rates are taken as velocities: exact at p = 0
    """
    turned = rotation @ Rotation.from_rotvec(displacement[:, 3:6]).as_matrix()
    return position + displacement[:, :3] @ rotation.T, turned, rates[:, :3] @ rotation.T, rates[:, 3:6]


def floating_node_motion(body: Deforming, motion: FloatingMotion, nodes: ArrayLike) -> NodeMotion:
    """Motion in space of some nodes of a body with a floating frame:

        r = R + A (x + u),   dr = dR + A (w x (x + u) + du)
        ddr = ddR + A (dw x (x + u) + w x (w x (x + u)) + 2 w x du + ddu)

    Raises ModelError for a node number outside the body.
    Source: [Wu2019] (3)-(4)
    """
    numbers = checked_nodes(nodes, len(body.nodes))
    q, dq, ddq = motion.coordinates, motion.coordinate_rates, motion.coordinate_accelerations
    parts = [_of_frame(body, q[rows], dq[rows], ddq[rows], numbers) for rows in time_slices(body, len(q))]
    displacement, rate, second = (np.concatenate(each) for each in zip(*parts, strict=True))
    moving = _in_space(motion, body.nodes[numbers] + displacement, rate, second)
    return moving._replace(position=floating_positions(body, motion, numbers))


def floating_interface_motion(interface: Interface, motion: FloatingMotion) -> InterfaceMotion:
    """Motion in space of an interface of a body with a floating frame.

    The point moves as in `floating_node_motion`; rotation and angular velocity are

    A_p = A exp(phi),   omega_p = A (w + exp(phi) T(phi) dphi),   phi = theta (1 + c theta.theta)
    """
    shapes = motion.coordinates, motion.coordinate_rates, motion.coordinate_accelerations
    moved, rate, second = (q @ interface.motion.T for q in shapes)
    place, turned = place_in_frame(interface, motion.coordinates)
    point = _in_space(motion, place[:, None], rate[:, None, :3], second[:, None, :3])
    own = np.einsum("tij,tj->ti", turned, _angular_velocity(interface.cubic_turn, moved[:, 3:], rate[:, 3:]))
    return InterfaceMotion(
        in_space(motion.position, motion.rotation, place[:, None])[:, 0],
        motion.rotation @ turned,
        point.velocity[:, 0],
        point.acceleration[:, 0],
        np.einsum("tij,tj->ti", motion.rotation, motion.angular_velocity + own),
    )


def _angular_velocity(cubic_turn: float, theta: FloatArray, rate: FloatArray) -> FloatArray:
    """Angular velocity T(phi) dphi (t, 3), relative to the frame and in the axes rotated by exp(phi):

    T(phi) dphi = dphi - (1 - cos p)/p^2 phi x dphi + (p - sin p)/p^3 phi x (phi x dphi),   p = |phi|
    """
    square = np.sum(theta**2, axis=1, keepdims=True)
    phi = theta * (1 + cubic_turn * square)
    dphi = rate * (1 + cubic_turn * square) + theta * (
        2 * cubic_turn * np.sum(theta * rate, axis=1, keepdims=True)
    )
    p = np.linalg.norm(phi, axis=1, keepdims=True)
    second = 0.5 * np.sinc(p / (2 * np.pi)) ** 2
    series = 1 / 6 - p**2 / 120 + p**4 / 5040
    third = np.where(p < 0.05, series, (p - np.sin(p)) / np.maximum(p, 0.05) ** 3)
    once = np.cross(phi, dphi)
    return dphi - second * once + third * np.cross(phi, once)


def _of_frame(
    body: Deforming, q: FloatArray, dq: FloatArray, ddq: FloatArray, nodes: NDArray[np.intp]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Displacements (t, k, 3) of some nodes in the frame, and their first and second time derivatives.

    Displacements are quadratic, u = V q + Z(q, q). expand_rates returns V dq + 2 Z(q, dq), and
    ddu = V ddq + 2 Z(q, ddq) + 2 Z(dq, dq).
    """
    quadratic = body.expand_rates(dq, dq, nodes) - body.expand_rates(np.zeros_like(dq), dq, nodes)
    rate, second = body.expand_rates(q, dq, nodes), body.expand_rates(q, ddq, nodes)
    return body.expand(q, nodes), rate, second + quadratic


def _in_space(motion: FloatingMotion, place: FloatArray, rate: FloatArray, second: FloatArray) -> NodeMotion:
    """Motion in space of points at `place` (t, k, 3) in the frame, from their time derivatives in the frame.

    rate, second : (t, k, 3) first and second time derivatives of `place`
    """
    w, dw = motion.angular_velocity[:, None], motion.angular_acceleration[:, None]
    turning = np.cross(w, place)
    velocity = turning + rate
    acceleration = np.cross(dw, place) + np.cross(w, turning) + 2 * np.cross(w, rate) + second

    def turned(vectors: FloatArray) -> FloatArray:
        return np.einsum("tij,tkj->tki", motion.rotation, vectors)

    return NodeMotion(
        motion.position[:, None] + turned(place),
        motion.velocity[:, None] + turned(velocity),
        motion.acceleration[:, None] + turned(acceleration),
    )
