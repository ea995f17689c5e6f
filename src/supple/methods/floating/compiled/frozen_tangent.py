"""Frozen tangent over several iterations and steps (modified Newton) for machines solved as one matrix.

With `S` the tangent of the bodies and `G` the rows of the joints, a correction solves

    [ S    G^T ] [ x ]     [ r ]          x = - S^-1 (r + G^T y)
    [ G_T  0   ] [ y ] = - [ g ],         G_T S^-1 G^T y = g - G_T S^-1 r

Only `S^-1` is frozen, with the translations of each body in body axes, where a rigid rotation does not change
it. The rows of the joints change with rotations, cost little, and are evaluated anew at every iterate. So the
error of a frozen tangent comes from later changes of deformations and angular velocities.

A step with a frozen tangent may also end without a last evaluation (`contraction`). With the residuals `s_0`,
`s_1` before and after a correction by the same tangent at the age of `n` steps,

    s_1' <= s_1 max(1, s_0' / s_0)^2 n' / n

is predicted at the age `n'`: the error of a tangent grows with its age. If ten times the predicted residual
is below the tolerance, the corrected iterate is accepted. A tangent whose measured contraction does not allow
this is renewed in the next step. If a tangent already fails at age one, each of the next `PAUSE` steps
computes its own tangent.

The iteration starts from the accelerations of the last step, or from their linear extrapolation over the last
two steps. The extrapolation is used if it would have been the better start of the last step. The smaller the
first residual, the older a tangent may be.
Source: [BrenanCampbellPetzold1996], section 5.2, for reuse of factors according to the convergence rate.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.machine_model import Model
from supple.methods.floating.compiled.contraction import LIKE, MEASURED_EVERY, is_predictable
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.step_equations import tree_layout

SLOWEST = 0.1
"""Ratio of successive residuals above which a frozen tangent is renewed."""
SHARE = 0.1
"""Part of the tolerance that the residual must reach after a correction with a frozen tangent."""
MARGIN = 10.0
"""The predicted residual must be below the tolerance by this factor."""
PAUSE = 16.0
"""Steps without a frozen tangent after a tangent that failed in its second step: where the steps do not
resolve the motion, freezing a tangent saves no time."""
_FEWEST = 10
"""Number of coordinates from which the tangent of a body with nonlinear stiffness is expensive."""


class FrozenInverse(NamedTuple):
    """Frozen inverse, with the measurements that determine whether it is used."""

    inverse: AnyArray
    """(n, n) inverse of the tangent without joints, translations in body axes"""
    step: AnyArray
    """Size of the step that computed the inverse, s; 0 if there is no inverse, or if it must be renewed"""
    age: AnyArray
    """Steps since the inverse was computed"""
    before: AnyArray
    """Residual relative to the tolerance before a measured correction; 0 where none was measured"""
    after: AnyArray
    measured_at: AnyArray
    """Age of the tangent at that measurement, steps"""
    phase: AnyArray
    """Steps since a measurement was due"""
    made: AnyArray
    """Number of tangents computed in the run"""
    pause: AnyArray
    """Number of coming steps that compute their own tangent"""
    acceleration: AnyArray
    """(n,) accelerations one step before the last"""
    last: AnyArray
    """Size of the last step, s"""
    lead: AnyArray
    """1 where accelerations are extrapolated linearly, 0 where those of the last step are the first guess"""


def freezes_tangent(model: Model) -> bool:
    """Whether a frozen tangent saves time; depends on the structure of the model alone."""
    dear = any(group.r >= _FEWEST and group.cubic is not None for group in model.groups)
    return dear and is_predictable(model) and tree_layout(model) is None


def no_tangent(model: Model) -> FrozenInverse:
    """State before the first step."""
    n = model.n_velocities
    none = np.zeros(())
    return FrozenInverse(np.zeros((n, n)), *[none] * 8, acceleration=np.zeros(n), last=none, lead=none)


def serves(kept: FrozenInverse, step: jax.Array) -> jax.Array:
    """Whether a step of this size can start with this tangent."""
    return jnp.abs(step - kept.step) <= 1e-6 * step


def predicted(kept: FrozenInverse, acceleration: jax.Array, step: jax.Array) -> jax.Array:
    """Start of the iteration: accelerations (n,) of the last step, or their linear extrapolation."""
    ahead = kept.lead * step / jnp.where(kept.last > 0, kept.last, jnp.inf)
    return acceleration + ahead * (acceleration - kept.acceleration)


def predicted_to_suffice(kept: FrozenInverse, size: jax.Array) -> jax.Array:
    """Whether a correction from a residual of this size is predicted to reach the tolerance."""
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
    """The frozen inverse and its measurements after an accepted step.

    kept : measurements before the step, with the inverse after it
    accelerations : (n,) before and after the step; scale : (n,) their scale
    made : number of tangents in the step
    sizes : (2,) residuals at the last two evaluations of the step, relative to the tolerance
    evaluated : whether the residual at the end of the step was evaluated
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
    """1 where linear extrapolation would have been closer to the accelerations at the end, otherwise 0."""
    before, after = accelerations
    change = after - before
    along = step / jnp.where(kept.last > 0, kept.last, jnp.inf) * (before - kept.acceleration)
    farther = jnp.max(jnp.abs(change - along) / scale) >= jnp.max(jnp.abs(change) / scale)
    return jnp.where(farther, 0.0, 1.0)


def bodies_inverse(
    elimination: DenseElimination, model: Model, rotations: jax.Array, tangent: jax.Array
) -> jax.Array:
    """Inverse of the bodies' tangent (n, n), with translations rotated from global to body axes."""
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
    """Solutions (n,) and (m,) of `S x + G^T y = load`, `G_T x = gap`.

    inverse : (n, n) inverse of S in body axes; rows, by_increment : (m, n) G and G_T
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
    """Columns (n, k) with translations rotated from global to body axes: `A^T x`."""
    parts: list[jax.Array] = []
    for number, part in enumerate(model.slices):
        frame = columns[part.start : part.start + 3]
        parts += [
            (rotations[number][:, :, None] * frame[:, None, :]).sum(axis=0),
            columns[part.start + 3 : part.stop],
        ]
    return jnp.concatenate(parts)
