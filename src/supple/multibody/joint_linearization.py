"""A joint at one configuration: its equations, their derivatives, and the stiffness of its forces.

Only the constraint equations are written by hand, in terms of the two joint frames. Their derivatives for
small motions of the frames follow by forward differentiation, twelve directions of simple algebra; how the
frames follow the bodies is analytic (`frame_motion`, `wrench_stiffness`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from supple.multibody.joints.joint import JointFrame
from supple.multibody.marker import Marker, frame_motion, orientation, point, wrench_stiffness
from supple.multibody.model import JointArrays

__all__ = ["JointLinearization", "geometric_stiffness", "joint_equations", "linearize_joint"]


class JointLinearization(NamedTuple):
    """What one evaluation of a joint leaves for forces, Jacobian and tangent."""

    equations: jax.Array
    """`g`, (m,)"""
    frames: tuple[JointFrame, JointFrame]
    motions: tuple[jax.Array, jax.Array]
    """(6, 12) each: motion of the joint frame per local freedom"""
    by_end: tuple[jax.Array, jax.Array]
    """(m, 12) each: equations per local freedom"""


def _frame(marker: Marker) -> JointFrame:
    return JointFrame(point(marker), orientation(marker))


def _value(joint: JointArrays, time: jax.Array) -> Any:
    return None if joint.law is None else joint.law(time)


def joint_equations(joint: JointArrays, first: Marker, second: Marker, time: jax.Array) -> jax.Array:
    """The joint's constraint equations, (m,)."""
    return joint.constraint(_frame(first), _frame(second), _value(joint, time))


def _nudged(frame: JointFrame, variation: jax.Array) -> JointFrame:
    """The frame after a small motion `(dr, dphi)`: exact to first order, which is all that is differentiated."""
    turned = frame.axes + jnp.cross(frame.axes, variation[3:][None, :])
    return JointFrame(frame.point + variation[:3], turned)


def _by_frame(joint: JointArrays, first: JointFrame, second: JointFrame, value: Any) -> jax.Array:
    """Derivative of the joint's equations for small motions of its frames, (m, 12)."""

    def equations(small: jax.Array) -> jax.Array:
        return joint.constraint(_nudged(first, small[:6]), _nudged(second, small[6:]), value)

    return jax.jacfwd(equations)(jnp.zeros(12))


def linearize_joint(
    joint: JointArrays, first: Marker, second: Marker, time: jax.Array
) -> JointLinearization:
    """Equations and derivatives of a joint whose markers are known."""
    frames = _frame(first), _frame(second)
    value = _value(joint, time)
    motions = frame_motion(first), frame_motion(second)
    by_frame = _by_frame(joint, *frames, value)
    return JointLinearization(
        equations=joint.constraint(*frames, value),
        frames=frames,
        motions=motions,
        by_end=(by_frame[:, :6] @ motions[0], by_frame[:, 6:] @ motions[1]),
    )


def geometric_stiffness(
    joint: JointArrays,
    at: JointLinearization,
    first: Marker,
    second: Marker,
    time: jax.Array,
    multipliers: jax.Array,
) -> jax.Array:
    """Change of the joint's generalised forces with the local freedoms at constant multipliers, (24, 24)."""
    value = _value(joint, time)

    def wrenches(small: jax.Array) -> tuple[jax.Array, jax.Array]:
        nudged = _nudged(at.frames[0], small[:6]), _nudged(at.frames[1], small[6:])
        both = _by_frame(joint, *nudged, value).T @ multipliers
        return both, both

    by_frame, wrench = jax.jacfwd(wrenches, has_aux=True)(jnp.zeros(12))
    motion = jax.scipy.linalg.block_diag(*at.motions)
    own = jax.scipy.linalg.block_diag(
        wrench_stiffness(first, wrench[:6]), wrench_stiffness(second, wrench[6:])
    )
    return motion.T @ by_frame @ motion + own
