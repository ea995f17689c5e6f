"""A tangent that is kept over iterations and steps (modified Newton), of machines solved as one matrix.

With `S` the tangent of the bodies and `G` the rows of the joints, a correction solves

    [ S    G^T ] [ x ]     [ r ]          x = - S^-1 (r + G^T y)
    [ G_T  0   ] [ y ] = - [ g ],         G_T S^-1 G^T y = g - G_T S^-1 r

Only `S^-1` is kept, with the translations of each body in its own axes: there it stays as it is while bodies
turn. What joints do changes with their turning, costs little, and is taken anew at every iterate. So a kept
tangent errs by deformations and angular velocities that have changed since.

A step with a frozen tangent may end without a last evaluation, too (`contraction`). With the sizes `s_0`,
`s_1` of the residual before and behind a correction by the same tangent, then `n` steps old,

    s_1' <= s_1 max(1, s_0' / s_0)^2 n' / n

is expected: what a tangent errs by grows with its age. Where ten times that is below the tolerance, the
corrected iterate is accepted. A tangent that is, when measured, not good for that is renewed in the next
step; where that happens at once, the next steps have a tangent each.

Iterations begin with the accelerations of the last step or, where that came nearer to the end of the last,
along the line through the last two. The smaller the first residual, the older a tangent may be.
Source: [BrenanCampbellPetzold1996], section 5.2, for keeping a factor by its rate.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.configuration import AnyArray
from supple.equations.machine_model import Model
from supple.methods.floating.compiled.contraction import LIKE, MEASURED_EVERY, is_predictable
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.step_equations import tree_layout

__all__ = [
    "SHARE",
    "SLOWEST",
    "FrozenInverse",
    "bodies_inverse",
    "freezes_tangent",
    "no_tangent",
    "predicted_to_suffice",
    "serves",
    "solution_by_parts",
    "used",
]

SLOWEST = 0.1
"""Rate beyond which a frozen tangent is renewed."""
SHARE = 0.1
"""Of the tolerance, what is asked of an iterate that a frozen tangent led to."""
MARGIN = 10.0
"""By which what is predicted must be below the tolerance."""
PAUSE = 16.0
"""Steps without a frozen tangent after one that did not outlive its first: where motions are not resolved, no
tangent is worth keeping."""
_FEWEST = 10
"""Coordinates of a body with nonlinear stiffness that make a tangent dear."""


class FrozenInverse(NamedTuple):
    """An inverse and what is known of it."""

    inverse: AnyArray
    """(n, n) of the tangent without joints, translations in the axes of the bodies"""
    step: AnyArray
    """Size of the step that it was made for, s; 0 where there is none yet, or it no longer serves"""
    age: AnyArray
    """Steps since it was made"""
    before: AnyArray
    """Residual in parts of the tolerance before a correction that was measured; 0 where none was"""
    after: AnyArray
    measured_at: AnyArray
    """Age of the tangent then"""
    phase: AnyArray
    """Steps since one was due to be measured"""
    made: AnyArray
    """Tangents so far"""
    pause: AnyArray
    """Steps that are yet to make their own"""
    acceleration: AnyArray
    """(n,) one step before the last"""
    last: AnyArray
    """Size of the last step, s"""
    lead: AnyArray
    """1 where accelerations are guessed along the line through the last two, 0 where they are the last"""


def freezes_tangent(model: Model) -> bool:
    """Whether a tangent costs more than what is solved with a kept one: known from the structure."""
    dear = any(group.r >= _FEWEST and group.cubic is not None for group in model.groups)
    return dear and is_predictable(model) and tree_layout(model) is None


def no_tangent(model: Model) -> FrozenInverse:
    """Before the first step."""
    n = model.n_velocities
    none = np.zeros(())
    return FrozenInverse(np.zeros((n, n)), *[none] * 8, acceleration=np.zeros(n), last=none, lead=none)


def serves(kept: FrozenInverse, step: jax.Array) -> jax.Array:
    """Whether a step of this size can begin with it."""
    return jnp.abs(step - kept.step) <= 1e-6 * step


def predicted(kept: FrozenInverse, acceleration: jax.Array, step: jax.Array) -> jax.Array:
    """Where the iteration of a step begins: with the accelerations (n,) of the last, or along a line."""
    ahead = kept.lead * step / jnp.where(kept.last > 0, kept.last, jnp.inf)
    return acceleration + ahead * (acceleration - kept.acceleration)


def predicted_to_suffice(kept: FrozenInverse, size: jax.Array) -> jax.Array:
    """Whether a correction from a residual of this size surely ends below the tolerance."""
    ratio = jnp.maximum(1.0, size / jnp.where(kept.before > 0, kept.before, 1.0))
    older = (kept.age + 1) / jnp.maximum(kept.measured_at, 1.0)
    comparable = (kept.phase > 0) & (size <= LIKE * kept.before)
    return comparable & (MARGIN * kept.after * ratio**2 * older <= 1.0)


def used(
    kept: FrozenInverse,
    step: jax.Array,
    accelerations: tuple[jax.Array, jax.Array],
    scale: jax.Array,
    made: jax.Array,
    sizes: jax.Array,
    corrections: jax.Array,
    evaluated: jax.Array,
) -> FrozenInverse:
    """What is known behind an accepted step.

    kept : with the inverse at its end; accelerations : before and behind it, (n,); scale : of them, (n,)
    made : tangents in it; sizes : (2,) of the residual at its last two evaluations, in parts of the tolerance
    evaluated : whether its end was
    """
    new = made > 0
    age = kept.age + 1
    measured = evaluated & (corrections == 1) & ~new
    after = kept._replace(
        step=jnp.where(new, step, kept.step),
        age=jnp.where(new, 0.0, age),
        before=jnp.where(new, 0.0, jnp.where(measured, sizes[0], kept.before)),
        after=jnp.where(measured, sizes[1], kept.after),
        measured_at=jnp.where(measured, age, kept.measured_at),
        phase=jnp.where(new, 0.0, (kept.phase + 1) % MEASURED_EVERY),
        made=kept.made + made,
        acceleration=accelerations[0],
        last=step,
        lead=_lead(kept, step, accelerations, scale),
    )
    tired = measured & (MARGIN * after.after * (age + 1) > age)
    worn = ~new & (tired | (corrections > 1))
    pause = jnp.where(worn & (age <= 1), PAUSE, jnp.maximum(kept.pause - 1.0, 0.0))
    return after._replace(step=jnp.where(worn | (pause > 0), 0.0, after.step), pause=pause)


def _lead(
    kept: FrozenInverse, step: jax.Array, accelerations: tuple[jax.Array, jax.Array], scale: jax.Array
) -> jax.Array:
    """1 where a line would have led nearer to the accelerations at the end of a step, 0 where rest would."""
    before, after = accelerations
    change = after - before
    along = step / jnp.where(kept.last > 0, kept.last, jnp.inf) * (before - kept.acceleration)
    farther = jnp.max(jnp.abs(change - along) / scale) >= jnp.max(jnp.abs(change) / scale)
    return jnp.where(farther, 0.0, 1.0)


def bodies_inverse(
    elimination: DenseElimination, model: Model, rotations: jax.Array, tangent: jax.Array
) -> jax.Array:
    """Inverse of the bodies' tangent (n, n), translations turned from global axes to those of the bodies."""
    own = _turned(model, rotations, _turned(model, rotations, tangent).T).T
    return elimination.inverse(own)


def solution_by_parts(
    elimination: DenseElimination,
    model: Model,
    rotations: jax.Array,
    inverse: jax.Array,
    rows: jax.Array,
    by_increment: jax.Array,
    load: jax.Array,
    gap: jax.Array,
) -> tuple[jax.Array, jax.Array]:
    """The solutions (n,) and (m,) of `S x + G^T y = load`, `G_T x = gap`.

    inverse : (n, n) of S, in the axes of the bodies; rows, by_increment : (m, n) G and G_T
    """
    solved = inverse @ _turned(model, rotations, jnp.concatenate([load[:, None], rows.T], axis=1))
    own, by_joints = solved[:, 0], solved[:, 1:]
    multipliers = gap
    if len(gap):
        joined = _turned(model, rotations, by_increment.T).T @ solved
        multipliers = elimination.solution(jnp.column_stack([joined[:, 1:], joined[:, 0] - gap]))
        own = own - by_joints @ multipliers
    return _turned(model, jnp.swapaxes(rotations, 1, 2), own[:, None])[:, 0], multipliers


def _turned(model: Model, rotations: jax.Array, columns: jax.Array) -> jax.Array:
    """Columns (n, k) whose translations are turned from global axes to those of the bodies: `A^T x`."""
    parts: list[Any] = []
    for number, part in enumerate(model.slices):
        frame = columns[part.start : part.start + 3]
        parts += [
            (rotations[number][:, :, None] * frame[:, None, :]).sum(axis=0),
            columns[part.start + 3 : part.stop],
        ]
    return jnp.concatenate(parts)
