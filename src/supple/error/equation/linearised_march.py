"""The integrator linearised about a run, driven by the run's own residual.

The unknowns are differences between the true motion and the run: `eps` of the positions (origin of the frame,
its rotation psi from A to A exp(psi), coordinates), `w` of the velocities, `c` and `a` of the true and the
auxiliary accelerations. `T` and `Ad`, the right Jacobian and the inverse rotation of the step, act on the
rows of rotations:

    a_k   = (alpha_f c_0 - alpha_m a_0) / (1 - alpha_m)
    eps_p = Ad eps_0 + T { h w_0 + h^2 [(1/2 - beta) a_0 + beta a_k] }
    w_p   = w_0 + h [(1 - gamma) a_0 + gamma a_k]

    [ M + v C + p K T   G^T ] [ c ]     [ r + K eps_p + C w_p ]
    [ G T                0  ] [ l ] = - [ (g + G eps_p) / p   ]

    eps = eps_p + p T c,   w = w_p + v c,   a = a_k + kappa c

M, C and K are the tangents of the run's own equations at its state; r and g are the residuals of these
equations and of the joints; p, v and kappa are the factors of the step (`StepFactors`). This step is the
exact derivative of the discrete run. The exception are rotations, which are composed exactly, to first order
with the same result: psi = log( exp(-Dpsi) exp(psi_0) exp(Dpsi + dturn) ). The corrected motion therefore
obeys the integrator, and the equation can be linearised again about this motion.
Source: original to this project; the step is that of Chung & Hulbert (1993) on the group of Arnold & Bruels
(2007).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import rotation_exp, rotation_log, rotation_right_jacobian
from supple.arrays import AnyArray
from supple.equations.balance import Linearization, balance, tangent
from supple.equations.compiler_options import MARCHING
from supple.equations.configuration import SystemMotion, advance
from supple.equations.joint_force import constraint_rows
from supple.equations.machine_model import STATIC, Model
from supple.integrate import Coefficients, StepFactors, StepRule
from supple.methods.floating.compiled.elimination import solve_bordering_column
from supple.programs.program_cache import CachedProgram


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ElasticGain:
    """Additional stiffness and damping of a deformed body, compared with the undeformed body."""

    start: int = field(metadata=STATIC)
    """Index of its first coordinate among the velocities"""
    stiffness: AnyArray
    """(m, k, k)"""
    viscous: AnyArray
    """(m, k, k): of damping, per unit of retardation time; (0, k, k) without strain-rate damping"""
    viscous_stiffness: AnyArray
    """(n, k, k): of the strain-rate stress, per unit of retardation time"""


class GainHistory(NamedTuple):
    """Additional forces of one body at every step, and the weights of its matrices."""

    force: AnyArray
    """(t, k) elastic, beyond the stiffness at rest"""
    viscous_force: AnyArray
    """(t, k) of the strain rates, beyond the damping at rest, per unit of retardation time"""
    weights: AnyArray
    """(t, m)"""
    rate_weights: AnyArray
    """(t, n)"""
    retardation: AnyArray
    """(t,) retardation time of the body"""


class StepOfRun(NamedTuple):
    """A step of the run and the state at its end; stacked over the steps."""

    h: AnyArray
    motion: SystemMotion
    """At the end of the step"""
    turn: AnyArray
    """(nb, 3) `Dpsi` of the frames"""
    gains: tuple[GainHistory, ...]


class ErrorState(NamedTuple):
    """True motion less the run's motion, (n,) each."""

    position: AnyArray
    velocity: AnyArray
    acceleration: AnyArray
    auxiliary: AnyArray
    multipliers: AnyArray
    """(m,)"""


_Gained: TypeAlias = tuple[jax.Array, jax.Array, jax.Array]
"""Additional force, tangent and damping of a body"""


class _Linearized(NamedTuple):
    """The run's equations at one state, and the contributions of known differences."""

    matrix: jax.Array
    """M + v C + p K T"""
    residual: jax.Array
    """r + K eps_p + C w_p"""
    rows: jax.Array
    """G"""
    columns: jax.Array
    """G T"""
    gap: jax.Array
    """g + G eps_p"""


def _linearized(
    model: Model,
    bodies: tuple[ElasticGain, ...],
    gains: Sequence[_Gained],
    motion: SystemMotion,
    increments: jax.Array,
    factors: StepFactors,
    known: tuple[jax.Array, jax.Array],
) -> _Linearized:
    """Residuals and tangents of the run's equations at one state.

    increments : (n,)   of the run's frames in the step, for T
    known : eps_p, w_p
    """

    def equations(
        position: jax.Array, velocity: jax.Array
    ) -> tuple[tuple[jax.Array, jax.Array], Linearization]:
        moved = advance(model, motion.configuration, position)
        terms = balance(model, motion._replace(configuration=moved, velocity=velocity))
        return (terms.residual, terms.constraint_residual), terms.linearization

    # The derivative along the known differences alone is cheaper than K and C.
    at = jnp.zeros_like(known[0]), motion.velocity
    (residual, gap), (more, moved), linearization = jax.jvp(equations, at, known, has_aux=True)
    residual = residual + more
    matrix = tangent(model, motion, linearization, increments, factors)
    n = model.n_velocities
    for body, (force, gained, viscous) in zip(bodies, gains, strict=True):
        around = (body.start, n - body.start - force.shape[0])
        own = slice(around[0], n - around[1])
        # Padded and added: writing into slices would loop over the entries, a millisecond per step.
        residual = residual + jnp.pad(force + gained @ known[0][own] + viscous @ known[1][own], around)
        more = factors.by_position * gained + factors.by_velocity * viscous
        matrix = matrix + jnp.pad(more, (around, around))
    joints = linearization.joints
    return _Linearized(
        matrix,
        residual,
        constraint_rows(model, joints),
        constraint_rows(model, joints, increments),
        gap + moved,
    )


def _weighted(body: ElasticGain, history: GainHistory) -> _Gained:
    """Additional force, tangent and damping of a body at every step of a block."""
    time = history.retardation[:, None]
    gained = jnp.tensordot(history.weights, body.stiffness, axes=1)
    gained = gained + jnp.tensordot(time * history.rate_weights, body.viscous_stiffness, axes=1)
    weights = time * history.weights[:, : body.viscous.shape[0]]
    force = history.force + time * history.viscous_force
    return force, gained, jnp.tensordot(weights, body.viscous, axes=1)


def _on_rotations(model: Model, matrices: jax.Array, vector: jax.Array) -> jax.Array:
    """Matrices (nb, 3, 3) applied to the rotation rows of every body; vector (n, ...)."""
    for part, matrix in zip(model.slices, matrices, strict=True):
        rows = slice(part.start + 3, part.start + 6)
        vector = vector.at[rows].set(matrix @ vector[rows])
    return vector


def _moved(model: Model, position: jax.Array, increment: jax.Array, turn: jax.Array) -> jax.Array:
    """Difference of positions after a step; `turn` (nb, 3) is the rotation of the run in it."""
    moved = position + increment
    for part, own in zip(model.slices, turn, strict=True):
        rows = slice(part.start + 3, part.start + 6)
        turned = rotation_exp(-own) @ rotation_exp(position[rows]) @ rotation_exp(own + increment[rows])
        moved = moved.at[rows].set(rotation_log(turned))
    return moved


def _solved(
    model: Model, matrix: jax.Array, rows: jax.Array, columns: jax.Array, force: jax.Array, gap: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Accelerations and multipliers that balance a force and close a constraint residual."""
    m = rows.shape[0]
    bordered = jnp.block(
        [
            [matrix, model.mass * rows.T, force[:, None]],
            [model.mass * columns, jnp.zeros((m, m)), model.mass * gap[:, None]],
        ]
    )
    solution = -solve_bordering_column(bordered)
    n = matrix.shape[0]
    return solution[:n], model.mass * solution[n:]


def first_error(
    model: Model,
    bodies: tuple[ElasticGain, ...],
    coefficients: Coefficients,
    at: StepOfRun,
    position: AnyArray,
    velocity: AnyArray,
) -> ErrorState:
    """The error at the start of a run: of its positions and velocities, and consistent accelerations.

    at : the start, as the end of a step of zero length, which changes accelerations only
    """
    none = np.zeros_like(velocity)
    start = ErrorState(position, velocity, none, none, np.zeros(len(model.active)))
    _, states = march_error(model, bodies, coefficients, start, at)
    first = jax.tree.map(lambda leaf: leaf[0], jax.device_get(states))
    return first._replace(position=position, velocity=velocity, auxiliary=first.acceleration)


def _march_error(
    model: Model,
    bodies: tuple[ElasticGain, ...],
    coefficients: Coefficients,
    start: ErrorState,
    steps: StepOfRun,
) -> tuple[ErrorState, ErrorState]:
    """The error after a block of steps of a run, and the errors of all its steps, stacked.

    model : equations in the columns of the error
    bodies : the nonlinear ones, in the order of `steps.gains`
    """
    gains = [_weighted(body, own) for body, own in zip(bodies, steps.gains, strict=True)]

    def one_step(
        before: ErrorState, step: tuple[tuple[jax.Array, SystemMotion, jax.Array], list[_Gained]]
    ) -> tuple[ErrorState, ErrorState]:
        (h, motion, turn), own_gains = step
        turned, turns = jax.vmap(lambda psi: (rotation_exp(-psi), rotation_right_jacobian(psi)))(turn)
        rule = StepRule(coefficients, h)
        by_position, by_velocity = rule.factors
        # The integration rule with zero new acceleration gives the known part.
        known = rule.auxiliary(jnp.zeros_like(before.velocity), before.acceleration, before.auxiliary)
        increment = rule.increment(before.velocity, before.auxiliary, known)
        position = _on_rotations(model, turned, before.position) + _on_rotations(model, turns, increment)
        velocity = rule.new_velocity(before.velocity, before.auxiliary, known)
        steps_increment = jnp.zeros_like(velocity).at[model.frames.index[:, 3:]].set(turn)
        at = _linearized(
            model, bodies, own_gains, motion, steps_increment, rule.factors, (position, velocity)
        )
        acceleration, multipliers = _solved(
            model,
            at.matrix,
            at.rows,
            at.columns,
            at.residual,
            # A step of zero length moves nothing, and accelerations close no constraint residual.
            jnp.where(h > 0, at.gap / jnp.where(h > 0, by_position, 1.0), 0.0),
        )
        increment = increment + by_position * acceleration
        after = ErrorState(
            _moved(model, before.position, increment, turn),
            velocity + by_velocity * acceleration,
            acceleration,
            rule.auxiliary(acceleration, before.acceleration, before.auxiliary),
            multipliers,
        )
        return after, after

    return jax.lax.scan(one_step, start, ((steps.h, steps.motion, steps.turn), gains))


march_error = CachedProgram(_march_error, MARCHING)
