"""Markers: the points and axes of a body at which joints and forces act.

A marker is at an interface (or node) p of a body. With the frame's origin `R` and rotation `A`, the rest
position `x_p`, and the displacement `u` and rotation `theta` relative to the frame,

    r_p = R + A (x_p + u),        A_p = A exp(phi) C,        phi = theta (1 + c theta.theta),

where the constant `C` rotates the interface's axes to those of the joint, and `c` is a third-order correction
of the rotation (`BodyInterface.cubic_turn`). The twelve *local freedoms* of a marker are the variations of
`(R, psi, u, theta)`, `dA = A skew(dpsi)`; `u` and `theta` are linear in the body's coordinates. So one
constant matrix (12 x (6 + r)) maps velocities of the body to local freedoms, and its transpose maps forces
back.

Source: [Wu2019] (1)-(5), (26)-(28).

Like the functions of rotations, those of markers are traced once for all uses (`algebra/rotation.py`).
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.algebra.rotation import (
    right_jacobian_slope,
    rotation_exp,
    rotation_right_jacobian,
    skew,
    small_product,
)
from supple.machine.pose import Pose, Wrench

N_LOCAL = 12
"""Number of local freedoms of a marker: `dR (3), dpsi (3), du (3), dtheta (3)`."""


class Marker(NamedTuple):
    """Kinematic state of one marker; fields have shape (3,) or (3, 3), `cubic_turn` ()."""

    origin: jax.Array
    """Frame origin `R`, global."""
    rotation: jax.Array
    """Frame rotation `A`, body to global."""
    displacement: jax.Array
    """`u`, body components."""
    rotation_vector: jax.Array
    """`theta`, body components."""
    cubic_turn: jax.Array
    """`c`, (), of the rotation vector `phi = theta (1 + c theta.theta)`."""
    offset: jax.Array
    """Rest position `x_p` in the body frame."""
    axes: jax.Array
    """Joint axes `C` in the interface's frame, as columns."""
    velocity: jax.Array
    """`dR/dt`, global."""
    angular_velocity: jax.Array
    """Angular velocity of the frame, body components."""
    displacement_rate: jax.Array
    rotation_vector_rate: jax.Array


@jax.jit
def displaced(marker: Marker, variation: jax.Array) -> Marker:
    """The marker after a finite displacement along its local freedoms; (12,) in the order of `N_LOCAL`."""
    return marker._replace(
        origin=marker.origin + variation[0:3],
        rotation=marker.rotation @ rotation_exp(variation[3:6]),
        displacement=marker.displacement + variation[6:9],
        rotation_vector=marker.rotation_vector + variation[9:12],
    )


def with_rates(marker: Marker, variation: jax.Array) -> Marker:
    """The marker with its velocities `(dR/dt, omega, du/dt, dtheta/dt)` changed by twelve values."""
    return marker._replace(
        velocity=marker.velocity + variation[0:3],
        angular_velocity=marker.angular_velocity + variation[3:6],
        displacement_rate=marker.displacement_rate + variation[6:9],
        rotation_vector_rate=marker.rotation_vector_rate + variation[9:12],
    )


def point(marker: Marker) -> jax.Array:
    """Global position `r_p`, (3,)."""
    return marker.origin + small_product(marker.rotation, marker.offset + marker.displacement)


def orientation(marker: Marker) -> jax.Array:
    """Global orientation `A_p` of the joint axes, as columns, (3, 3)."""
    return small_product(small_product(marker.rotation, _tilt(marker)), marker.axes)


@jax.jit
def _tilt(marker: Marker) -> jax.Array:
    """exp(phi), (3, 3)."""
    theta = marker.rotation_vector
    return rotation_exp((1 + marker.cubic_turn * (theta @ theta)) * theta)


@jax.jit
def _turning(theta: jax.Array, cubic_turn: jax.Array) -> jax.Array:
    """T(phi) dphi/dtheta (3, 3): the angular velocity per rate of theta, in the rotated axes."""
    square = theta @ theta
    phi = (1 + cubic_turn * square) * theta
    by_theta = (1 + cubic_turn * square) * jnp.eye(3) + 2 * cubic_turn * jnp.outer(theta, theta)
    return small_product(rotation_right_jacobian(phi), by_theta)


@jax.jit
def pose(marker: Marker) -> Pose:
    """The pose and velocities of the marker, for force elements."""
    arm = marker.offset + marker.displacement
    seen = jnp.cross(marker.angular_velocity, arm) + marker.displacement_rate
    tilted = _tilt(marker)
    own = _turning(marker.rotation_vector, marker.cubic_turn) @ marker.rotation_vector_rate
    return Pose(
        point=point(marker),
        axes=orientation(marker),
        velocity=marker.velocity + marker.rotation @ seen,
        angular_velocity=marker.rotation @ tilted @ (tilted.T @ marker.angular_velocity + own),
    )


@jax.jit
def pose_at_rest(marker: Marker) -> Pose:
    """The pose of the marker, with zero velocities, for joints."""
    return Pose(point(marker), orientation(marker), jnp.zeros(3), jnp.zeros(3))


@jax.jit
def generalized_force(marker: Marker, wrench: Wrench) -> jax.Array:
    """Generalised forces (12,), conjugate to the local freedoms, of a wrench on the marker.

    Q_R = F,   Q_psi = (x + u) x A^T F + A^T M,   Q_u = A^T F,
    Q_theta = (T(phi) dphi/dtheta)^T exp(phi)^T A^T M
    """
    force = marker.rotation.T @ wrench.force
    moment = marker.rotation.T @ wrench.moment
    arm = marker.offset + marker.displacement
    turning = _turning(marker.rotation_vector, marker.cubic_turn)
    conjugate_to_turn = turning.T @ (_tilt(marker).T @ moment)
    return jnp.concatenate([wrench.force, jnp.cross(arm, force) + moment, force, conjugate_to_turn])


@jax.jit
def frame_map(marker: Marker) -> jax.Array:
    """Map of the twelve local freedoms to the joint frame: `(dr global, dphi in the joint's axes)`, (6, 12).

    dr = dR + A (du - (x + u)~ dpsi),      dphi = C^T ( exp(phi)^T dpsi + T(phi) dphi/dtheta dtheta )
    """
    arm = marker.offset + marker.displacement
    turned = small_product(_tilt(marker), marker.axes).T
    zero = jnp.zeros((3, 3))
    shift = jnp.concatenate(
        [jnp.eye(3), -small_product(marker.rotation, skew(arm)), marker.rotation, zero], axis=1
    )
    by_turn = small_product(marker.axes.T, _turning(marker.rotation_vector, marker.cubic_turn))
    turn = jnp.concatenate([zero, turned, zero, by_turn], axis=1)
    return jnp.concatenate([shift, turn])


@jax.jit
def wrench_stiffness(marker: Marker, wrench: jax.Array, motion: jax.Array) -> jax.Array:
    """Derivative of `frame_map(marker)^T wrench` by the local freedoms at constant wrench, (12, 12).

    `wrench` (6,) is the force in global components and the moment in the joint's axes; `motion` (6, 12) is
    the `frame_map`.
    """
    arm = marker.offset + marker.displacement
    force = skew(small_product(marker.rotation.T, wrench[:3]))
    turned, turning = motion[3:, 3:6], motion[3:, 9:]
    tilted = small_product(turned.T, small_product(skew(wrench[3:]), turning))
    zero = jnp.zeros((3, 3))
    by_turn = _turning_slope(marker, small_product(marker.axes, wrench[3:]))
    of_spin = jnp.concatenate([zero, small_product(skew(arm), force), -force, -tilted], axis=1)
    return jnp.concatenate(
        [
            jnp.zeros((3, 12)),
            of_spin,
            jnp.concatenate([zero, force, zero, zero], axis=1),
            jnp.concatenate([zero, zero, zero, by_turn], axis=1),
        ]
    )


def _turning_slope(marker: Marker, moment: jax.Array) -> jax.Array:
    """Derivative of `(T(phi) dphi/dtheta)^T moment` with respect to theta, (3, 3)."""
    theta, cubic = marker.rotation_vector, marker.cubic_turn
    stretch = 1 + cubic * (theta @ theta)
    carried, slope = right_jacobian_slope(stretch * theta, moment)
    by_theta = stretch * jnp.eye(3) + 2 * cubic * jnp.outer(theta, theta)
    mixed = jnp.outer(theta, carried)
    bent = 2 * cubic * (mixed + mixed.T + (theta @ carried) * jnp.eye(3))
    return small_product(by_theta, small_product(slope, by_theta)) + bent
