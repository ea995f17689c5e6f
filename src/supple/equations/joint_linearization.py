"""A joint at one configuration: its equations, their derivatives, and the stiffness of its forces.

Constraint equations depend on the two joint frames through the second's position and orientation relative to
the first, and are affine in both:

    g = L (d, Q) + b,      d = A_1^T (r_2 - r_1),     Q = A_1^T A_2

so that `L` and `b`, which depend at most on time, determine a joint completely, and the derivatives have the
same form for every kind. For small motions `(dr, dphi)` of the frames, `dA = A skew(dphi)`:

    dd = A_1^T (dr_2 - dr_1) + d x dphi_1,      dQ = Q skew(dphi_2) - skew(dphi_1) Q
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra import read_only
from supple.algebra.rotation import skew, small_product
from supple.arrays import AnyArray
from supple.equations.compiler_options import STARTING
from supple.equations.marker import (
    Marker,
    frame_map,
    orientation,
    point,
    pose_at_rest,
    wrench_stiffness,
)
from supple.machine.pose import Pose
from supple.programs.program_cache import CachedProgram


class JointLinearization(NamedTuple):
    """Results of one evaluation of a joint, for forces, Jacobian and tangent."""

    equations: jax.Array
    """`g`, (m,)"""
    axes: jax.Array
    """`A_1`, (3, 3)"""
    offset: jax.Array
    """`d`, (3,)"""
    rotation: jax.Array
    """`Q`, (3, 3)"""
    motions: tuple[jax.Array, jax.Array]
    """(6, 12) each: motion of the joint frame per local freedom"""
    by_end: tuple[jax.Array, jax.Array]
    """(m, 12) each: derivatives of the equations by local freedoms"""


Constraint = Callable[..., jax.Array]
"""The equations of a joint, from the poses of its ends and the value of its law."""


def joint_equations(
    constraint: Constraint, first: Marker, second: Marker, value: AnyArray | None
) -> jax.Array:
    """The joint's constraint equations, (m,)."""
    return constraint(pose_at_rest(first), pose_at_rest(second), value)


def _affine(constraint: Constraint, value: AnyArray | None) -> tuple[jax.Array, jax.Array]:
    """`L` (m, 12) and `b` (m,) of the joint's equations."""

    def of_relative(relative: jax.Array) -> jax.Array:
        still = jnp.zeros(3)
        first = Pose(still, jnp.eye(3), still, still)
        return constraint(first, Pose(relative[:3], relative[3:].reshape(3, 3), still, still), value)

    origin = jnp.zeros(12)
    return jax.jacfwd(of_relative)(origin), of_relative(origin)


Affine = tuple[AnyArray, AnyArray]
"""`L` (m, 12), for `d` and for `Q` row by row, and `b` (m,)"""


def affine_form(constraint: Constraint, value: AnyArray | None) -> Affine:
    """The affine form of a joint's equations.

    For a joint without a law (`value` is None), `L` and `b` are constants of the compiled program.
    """
    return _constant(constraint) if value is None else _affine(constraint, value)


@lru_cache(maxsize=64)
def _constant(constraint: Constraint) -> Affine:
    """The affine form of a joint without a law, computed by a small program of its own during tracing."""
    coefficients, constant = map(read_only, CachedProgram(partial(_affine, constraint, None), STARTING)())
    return coefficients, constant


@jax.jit
def axial(matrix: jax.Array) -> jax.Array:
    """`ax(M)` with `ax(M) . phi = M : skew(phi)`; (..., 3, 3) to (..., 3)."""
    return jnp.stack(
        [
            matrix[..., 2, 1] - matrix[..., 1, 2],
            matrix[..., 0, 2] - matrix[..., 2, 0],
            matrix[..., 1, 0] - matrix[..., 0, 1],
        ],
        axis=-1,
    )


def _seen(second: Marker, coefficients: AnyArray) -> Marker:
    """The second marker, without a rotation that the joint ignores: the compiler then drops unused terms."""
    if isinstance(coefficients, np.ndarray) and not coefficients[:, 3:].any():
        return second._replace(rotation_vector=jnp.zeros(3))
    return second


def linearize_joint(affine: Affine, first: Marker, second: Marker) -> JointLinearization:
    """Equations and derivatives of a joint with given affine form and markers."""
    coefficients, constant = affine
    second = _seen(second, coefficients)
    axes = orientation(first)
    gap = small_product(axes.T, point(second) - point(first))
    turn = small_product(axes.T, orientation(second))
    of_gap, of_turn = coefficients[:, :3], coefficients[:, 3:].reshape(-1, 3, 3)
    by_point = of_gap @ axes.T
    by_turns = (
        jnp.cross(of_gap, gap) - axial(of_turn @ turn.T),
        axial(turn.T @ of_turn),
    )
    motions = frame_map(first), frame_map(second)
    return JointLinearization(
        equations=coefficients @ jnp.concatenate([gap, turn.reshape(9)]) + constant,
        axes=axes,
        offset=gap,
        rotation=turn,
        motions=motions,
        by_end=(
            small_product(jnp.concatenate([-by_point, by_turns[0]], axis=1), motions[0]),
            small_product(jnp.concatenate([by_point, by_turns[1]], axis=1), motions[1]),
        ),
    )


Blocks = tuple[tuple[jax.Array, jax.Array], tuple[jax.Array, jax.Array]]


def geometric_stiffness(
    coefficients: AnyArray, at: JointLinearization, first: Marker, second: Marker, multipliers: jax.Array
) -> Blocks:
    """Derivative of the joint's generalised forces by the local freedoms at constant multipliers.

    With `p = L_d^T lambda` and `P = L_Q^T lambda` the wrenches on the joint frames are

        first: (-A_1 p, p x d - ax(P Q^T)),      second: (A_1 p, ax(Q^T P))

    Blocks (12, 12): rows of the first and second end, columns of the first and second end.
    """
    second = _seen(second, coefficients)
    weights = multipliers @ coefficients
    force, moments = weights[:3], weights[3:].reshape(3, 3)
    on_first, on_second = small_product(moments, at.rotation.T), small_product(at.rotation.T, moments)
    pull = small_product(at.axes, force)
    wrenches = (
        jnp.concatenate([-pull, jnp.cross(force, at.offset) - axial(on_first)]),
        jnp.concatenate([pull, axial(on_second)]),
    )
    trace = jnp.trace(on_second) * jnp.eye(3)
    swing = small_product(at.axes, skew(force))
    mixed = small_product(trace - on_first.T, at.rotation)
    tilted = small_product(skew(force), skew(at.offset)) - trace + on_first.T
    (shift, turn), (other_shift, other_turn) = (jnp.split(motion, 2) for motion in at.motions)
    pulled = small_product(swing.T, shift)
    across = small_product(turn.T, small_product(mixed, other_turn) - small_product(swing.T, other_shift))
    own = small_product(turn.T, pulled + small_product(tilted, turn)) + small_product(pulled.T, turn)
    other = small_product(other_turn.T, small_product(on_second - trace, other_turn))
    return (
        (own + wrench_stiffness(first, wrenches[0], at.motions[0]), across),
        (across.T, other + wrench_stiffness(second, wrenches[1], at.motions[1])),
    )
