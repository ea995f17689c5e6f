"""A joint at one configuration: its equations, their derivatives, and the stiffness of its forces.

Constraint equations see the two joint frames through the second's position and orientation relative to the
first, and are affine in both:

    g = L (d, Q) + c,      d = A_1^T (r_2 - r_1),     Q = A_1^T A_2

so that `L` and `c`, functions of time at most, are all there is to know of a joint, and the derivatives are
the same few lines for every kind. For small motions `(dr, dphi)` of the frames, `dA = A skew(dphi)`:

    dd = A_1^T (dr_2 - dr_1) + d x dphi_1,      dQ = Q skew(dphi_2) - skew(dphi_1) Q
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import skew
from supple.algebra.small_product import small_product
from supple.machine.joints.joint import JointFrame
from supple.machine.pose import Marker, frame_motion, orientation, point, wrench_stiffness
from supple.multibody.equations.model import JointArrays

__all__ = ["Blocks", "JointLinearization", "geometric_stiffness", "joint_equations", "linearize_joint"]


class JointLinearization(NamedTuple):
    """What one evaluation of a joint leaves for forces, Jacobian and tangent."""

    equations: jax.Array
    """`g`, (m,)"""
    coefficients: jax.Array
    """`L`, (m, 12): for `d` and for `Q` row by row"""
    axes: jax.Array
    """`A_1`, (3, 3)"""
    gap: jax.Array
    """`d`, (3,)"""
    turn: jax.Array
    """`Q`, (3, 3)"""
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


def _affine(joint: JointArrays, value: Any) -> tuple[jax.Array, jax.Array]:
    """`L` (m, 12) and `c` (m,) of the joint's equations."""

    def of_relative(relative: jax.Array) -> jax.Array:
        first = JointFrame(jnp.zeros(3), jnp.eye(3))
        return joint.constraint(first, JointFrame(relative[:3], relative[3:].reshape(3, 3)), value)

    origin = jnp.zeros(12)
    return jax.jacfwd(of_relative)(origin), of_relative(origin)


def affine_form(joint: JointArrays, time: jax.Array) -> tuple[Any, Any]:
    """`L` and `c` at a time; constants of the compiled program for a joint without a law."""
    if joint.law is None:
        with jax.ensure_compile_time_eval():
            coefficients, constant = _affine(joint, None)
        return np.asarray(coefficients), np.asarray(constant)
    return _affine(joint, _value(joint, time))


def _axial(matrix: jax.Array) -> jax.Array:
    """`ax(M)` with `ax(M) . phi = M : skew(phi)`; (..., 3, 3) to (..., 3)."""
    return jnp.stack(
        [
            matrix[..., 2, 1] - matrix[..., 1, 2],
            matrix[..., 0, 2] - matrix[..., 2, 0],
            matrix[..., 1, 0] - matrix[..., 0, 1],
        ],
        axis=-1,
    )


def _seen(second: Marker, coefficients: Any) -> Marker:
    """The second marker, unturned where the joint does not see it turn: the compiler drops what follows."""
    if isinstance(coefficients, np.ndarray) and not coefficients[:, 3:].any():
        return second._replace(turn=jnp.zeros(3))
    return second


def linearize_joint(joint: JointArrays, first: Marker, second: Marker, time: jax.Array) -> JointLinearization:
    """Equations and derivatives of a joint whose markers are known."""
    coefficients, constant = affine_form(joint, time)
    second = _seen(second, coefficients)
    frames = _frame(first), _frame(second)
    axes = frames[0].axes
    gap = small_product(axes.T, frames[1].point - frames[0].point)
    turn = small_product(axes.T, frames[1].axes)
    of_gap, of_turn = coefficients[:, :3], coefficients[:, 3:].reshape(-1, 3, 3)
    by_point = of_gap @ axes.T
    by_turns = (
        jnp.cross(of_gap, gap) - _axial(of_turn @ turn.T),
        _axial(turn.T @ of_turn),
    )
    motions = frame_motion(first), frame_motion(second)
    return JointLinearization(
        equations=coefficients @ jnp.concatenate([gap, turn.reshape(9)]) + constant,
        coefficients=coefficients,
        axes=axes,
        gap=gap,
        turn=turn,
        motions=motions,
        by_end=(
            small_product(jnp.concatenate([-by_point, by_turns[0]], axis=1), motions[0]),
            small_product(jnp.concatenate([by_point, by_turns[1]], axis=1), motions[1]),
        ),
    )


Blocks = tuple[tuple[jax.Array, jax.Array], tuple[jax.Array, jax.Array]]


def geometric_stiffness(
    at: JointLinearization, first: Marker, second: Marker, multipliers: jax.Array
) -> Blocks:
    """Change of the joint's generalised forces with the local freedoms at constant multipliers.

    With `p = L_d^T lambda` and `P = L_Q^T lambda` the wrenches on the joint frames are

        first: (-A_1 p, p x d - ax(P Q^T)),      second: (A_1 p, ax(Q^T P))

    Blocks (12, 12): rows of the first and second end, columns of the first and second end.
    """
    second = _seen(second, at.coefficients)
    weights = multipliers @ at.coefficients
    force, moments = weights[:3], weights[3:].reshape(3, 3)
    on_first, on_second = small_product(moments, at.turn.T), small_product(at.turn.T, moments)
    pull = small_product(at.axes, force)
    wrenches = (
        jnp.concatenate([-pull, jnp.cross(force, at.gap) - _axial(on_first)]),
        jnp.concatenate([pull, _axial(on_second)]),
    )
    trace = jnp.trace(on_second) * jnp.eye(3)
    zero = jnp.zeros((3, 3))
    swing = small_product(at.axes, skew(force))
    mixed = small_product(trace - on_first.T, at.turn)

    def framed(rows: int, columns: int, block: list[list[jax.Array]]) -> jax.Array:
        return small_product(small_product(at.motions[rows].T, jnp.block(block)), at.motions[columns])

    turned = at.motions[1][3:]
    tilted = small_product(skew(force), skew(at.gap)) - trace + on_first.T
    return (
        (
            framed(0, 0, [[zero, swing], [swing.T, tilted]]) + wrench_stiffness(first, wrenches[0]),
            framed(0, 1, [[zero, zero], [-swing.T, mixed]]),
        ),
        (
            framed(1, 0, [[zero, -swing], [zero, mixed.T]]),
            small_product(small_product(turned.T, on_second - trace), turned)
            + wrench_stiffness(second, wrenches[1]),
        ),
    )
