"""Motion of the second end of an element relative to the first, and pairs of balanced forces."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.machine.pose import Pose, Wrench


class AxialMotion(NamedTuple):
    """Motion of the second end about and along the first end's z axis."""

    angle: jax.Array
    """phi in (-pi, pi], zero at assembly"""
    rate: jax.Array
    """`z_1 . (omega_2 - omega_1)`, equal to dphi/dt while the z axes are parallel"""
    slide: jax.Array
    """`z_1 . (r_2 - r_1)`"""
    speed: jax.Array
    """Rate d slide/dt along the rotating z axis of the first end"""


def axial_motion(first: Pose, second: Pose) -> AxialMotion:
    """Angle, slide and their rates; a tilt of the second end's z axis does not change the angle.

    `tan(phi) = (y_1 . x_2 - x_1 . y_2) / (x_1 . x_2 + y_1 . y_2)`
    """
    x, y, z = first.axes.T
    sine = y @ second.axes[:, 0] - x @ second.axes[:, 1]
    cosine = x @ second.axes[:, 0] + y @ second.axes[:, 1]
    between = second.point - first.point
    # Velocity relative to axes that rotate with the first end.
    moving = second.velocity - first.velocity - jnp.cross(first.angular_velocity, between)
    return AxialMotion(
        angle=jnp.arctan2(sine, cosine),
        rate=z @ (second.angular_velocity - first.angular_velocity),
        slide=z @ between,
        speed=z @ moving,
    )


def moment_pair(first: Pose, moment: jax.Array) -> tuple[Wrench, Wrench]:
    """Wrenches on both ends: a moment about z_1 on the second end, and the opposite moment on the first."""
    own = moment * first.axes[:, 2]
    return Wrench(jnp.zeros(3), -own), Wrench(jnp.zeros(3), own)


def force_pair(first: Pose, second: Pose, force: jax.Array, moment: jax.Array) -> tuple[Wrench, Wrench]:
    """Wrenches on both ends: force and moment on the second end, and the balancing wrench on the first."""
    arm = second.point - first.point
    return Wrench(-force, -moment - jnp.cross(arm, force)), Wrench(force, moment)


class LineMotion(NamedTuple):
    """Relative motion of two points along the line between them."""

    length: jax.Array
    """Distance of the points"""
    rate: jax.Array
    """Rate of the distance"""
    direction: jax.Array
    """(3,) unit vector from the first point to the second, global"""


def line_motion(first: Pose, second: Pose) -> LineMotion:
    """Motion of the second point relative to the first along their line; the points must not coincide."""
    between = second.point - first.point
    length = jnp.sqrt(between @ between)
    direction = between / length
    return LineMotion(length, direction @ (second.velocity - first.velocity), direction)


def tension_pair(motion: LineMotion, tension: jax.Array) -> tuple[Wrench, Wrench]:
    """Forces that pull the two points together, or push them apart if the tension is negative."""
    force = tension * motion.direction
    return Wrench(force, jnp.zeros(3)), Wrench(-force, jnp.zeros(3))


def wrapped(angle: jax.Array) -> jax.Array:
    """The angle reduced to (-pi, pi] by whole revolutions."""
    return angle - 2 * jnp.pi * jnp.ceil((angle - jnp.pi) / (2 * jnp.pi))
