"""Modified Newton iteration within a step, with a tangent frozen over iterations and steps.

A tangent that reduces the residual less than tenfold in an iteration is renewed at that iterate. A tangent
whose single correction is not predicted to reach the tolerance is renewed in the next step
(`frozen_tangent`).
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from supple.equations.balance import tangent
from supple.equations.coordinate_scales import position_scale
from supple.equations.joint_force import constraint_rows
from supple.equations.machine_model import Model
from supple.integrate import StepRule
from supple.methods.floating.compiled.contraction import Contraction, predicted_to_converge
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.frozen_tangent import (
    SHARE,
    SLOWEST,
    FrozenInverse,
    bodies_inverse,
    predicted_to_suffice,
    serves,
    solution_by_parts,
    used,
)
from supple.methods.floating.compiled.iterate import Trial, linearized
from supple.methods.floating.compiled.newton import Assessed, Iteration, Modified
from supple.methods.floating.compiled.state import State

_SOON = 2
"""Evaluations of a step after which the whole tolerance suffices: rounding may prevent a smaller residual."""


def modified_pass(
    elimination: DenseElimination,
    model: Model,
    rule: StepRule,
    start: State,
    old: Iteration,
    trial: Trial,
    size: jax.Array,
    stagnant: jax.Array,
) -> Assessed:
    """Correction of an iterate that has not converged, with the frozen tangent where possible.

    size : residual relative to the tolerance; stagnant : whether the last correction changed nothing
    """
    assert old.modified is not None
    assert start.kept is not None
    before = old.modified
    first = old.evaluations == 0
    rate = jnp.where(first, 0.0, size / old.sizes[1])
    gains = rate <= SLOWEST
    share = jnp.where(before.own | (old.evaluations > _SOON), 1.0, SHARE)
    converged = (trial.converged & (size <= share)) | (stagnant & (gains | before.own))
    anew = ~converged & ~jnp.where(first, serves(start.kept, rule.h), gains)
    change, multiplier_change, inverse = jax.lax.cond(
        converged,
        lambda: (jnp.zeros_like(trial.acceleration), jnp.zeros_like(trial.multipliers), before.inverse),
        lambda: _correction(elimination, model, rule, start, trial, before.inverse, anew),
    )
    # Predicted from earlier steps alone: the first correction of a step does not predict its second one.
    predicted = jnp.where(
        anew, predicted_to_converge(start.contraction, size, rule.h), predicted_to_suffice(start.kept, size)
    )
    predicted = first & ~converged & predicted
    return Assessed(
        converged, predicted, change, multiplier_change, Modified(inverse, anew, before.made + anew)
    )


def _correction(
    elimination: DenseElimination,
    model: Model,
    rule: StepRule,
    start: State,
    trial: Trial,
    kept: jax.Array,
    anew: jax.Array,
) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Changes of accelerations and multipliers, and the inverse that was used."""
    rotations, joints = trial.configuration.rotations, trial.linearization.joints

    def made() -> jax.Array:
        return bodies_inverse(elimination, model, rotations, tangent(model, *linearized(rule, start, trial)))

    inverse = jax.lax.cond(anew, made, lambda: kept)
    change, multiplier_change = solution_by_parts(
        elimination,
        model,
        rotations,
        inverse,
        constraint_rows(model, joints),
        constraint_rows(model, joints, trial.increments),
        -trial.residual,
        -trial.constraint_residual / rule.factors.by_position,
    )
    return change, multiplier_change, inverse


def used_in_step(
    model: Model, start: State, step: jax.Array, end: Iteration, contraction: Contraction
) -> tuple[Contraction, FrozenInverse]:
    """The frozen tangent and its measurements after an accepted step.

    contraction : contraction measured by the last correction, if that used a new tangent
    """
    assert end.modified is not None
    assert start.kept is not None
    made = end.modified.made
    of_new = jax.tree.map(
        lambda own, known: jnp.where(made > 0, own, known), contraction, Contraction(*start.contraction)
    )
    kept = used(
        start.kept._replace(inverse=end.modified.inverse),
        step,
        (start.acceleration, end.acceleration),
        position_scale(model),
        made,
        end.sizes,
        end.corrections,
        end.converged,
    )
    return of_new, kept
