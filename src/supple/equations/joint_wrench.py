"""Joint forces: the six components that each joint exerts on its second end, from its multipliers.

The joint's equations are affine, `g = L (d, Q) + b` (`joint_linearization`), in the position d and the
rotation Q of the second end relative to the first, along the joint axes on the first end. With the
multipliers lambda, `p = L_d^T lambda`, `P = L_Q^T lambda`, and

    ax(M) = (M_32 - M_23, M_13 - M_31, M_21 - M_12),

the joint exerts on the second end, at that end's point and along the same axes,

    force  -p,        moment  -ax(P Q^T).

The first end receives the opposite wrench, at the same point.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial

import jax
import jax.numpy as jnp
import numpy as np

from supple.body import place_in_frame
from supple.equations.compiler_options import STARTING
from supple.equations.joint_linearization import affine_form
from supple.integrate import FramedMotion, Motion
from supple.machine import GROUND, At, Joint, System, TimeLaw
from supple.programs.program_cache import CachedProgram
from supple.value_content import fixed_function

# Number of times in one block. The last block is padded, so that one compiled program serves runs of any
# length.
_BLOCK = 2048


def joint_wrenches(
    system: System, times: np.ndarray, bodies: Mapping[str, Motion], multipliers: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Force and moment (t, 6) of each joint on its second end, at that end's point.

    Components are along the joint axes, which rotate with the first end; z is the joint's axis. Components
    along free directions are zero.

    Parameters
    ----------
    times : (t,)
    bodies : motions by body name, of t times
    multipliers : by joint name, (t, m)
    """
    return {
        joint.name: _wrench(system, joint, times, bodies, np.asarray(multipliers[joint.name]))
        for joint in system.joints
    }


def _wrench(
    system: System, joint: Joint, times: np.ndarray, bodies: Mapping[str, Motion], multipliers: np.ndarray
) -> np.ndarray:
    weights = np.einsum("tm,tmk->tk", multipliers, _coefficients(joint, times))
    wrench = np.zeros((len(times), 6))
    wrench[:, :3] = -weights[:, :3]
    by_turn = weights[:, 3:].reshape(-1, 3, 3)
    if by_turn.any():
        axes = (_axes(system, joint, end, bodies) for end in (joint.first, joint.second))
        turn = np.einsum("...ji,...jk->...ik", *axes)
        on_turn = by_turn @ np.swapaxes(turn, -1, -2)
        later, next_ = [2, 0, 1], [1, 2, 0]
        wrench[:, 3:] = on_turn[:, next_, later] - on_turn[:, later, next_]
    return wrench + 0.0  # no negative zeros


def _axes(system: System, joint: Joint, end: At, bodies: Mapping[str, Motion]) -> np.ndarray:
    """Joint axes on an end over time, (t, 3, 3), or (1, 3, 3) for the ground."""
    if end == GROUND:
        return joint.initial_axes[None]
    placed, motion = system.bodies[system.body_index(end.body)], bodies[end.body].of_type(FramedMotion)
    _, turn = place_in_frame(placed.body.interface(end.interface), motion.coordinates)
    return motion.rotation @ turn @ placed.assembly.rotation.T @ joint.initial_axes


def _coefficients(joint: Joint, times: np.ndarray) -> np.ndarray:
    """`L` (t, m, 12) of the equations of a joint."""
    constraint = fixed_function(type(joint).constraint)
    law = joint.law
    if law is None:
        coefficients, _ = affine_form(constraint, None)
        return np.broadcast_to(coefficients, (len(times), joint.n_constraints, 12))
    padded = np.pad(times, (0, -len(times) % _BLOCK), mode="edge").reshape(-1, _BLOCK)
    blocks = (_program(constraint)(law, block) for block in padded)
    return np.concatenate([np.asarray(block) for block in blocks])[: len(times)]


@lru_cache
def _program(constraint: Callable[..., jax.Array]) -> CachedProgram:
    return CachedProgram(partial(_linearized, constraint), STARTING)


def _linearized(constraint: Callable[..., jax.Array], law: TimeLaw, times: jax.Array) -> jax.Array:
    return jax.vmap(lambda time: affine_form(constraint, jnp.asarray(law(time)))[0])(times)
