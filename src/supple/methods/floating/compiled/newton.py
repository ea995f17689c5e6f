"""Newton's iteration within a step: the exact tangent of every iterate."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from supple.equations.balance import Linearization
from supple.equations.machine_model import Model
from supple.integrate import StepRule
from supple.methods.floating.compiled.contraction import is_predictable, predicted_to_converge
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.iterate import ReachedState, Trial, motion_of
from supple.methods.floating.compiled.sequential_vmap import sequential_vmap
from supple.methods.floating.compiled.state import State
from supple.methods.floating.compiled.step_equations import LinearizedStep, correction

__all__ = ["Assessed", "Iteration", "Modified", "newton_pass"]


class Iteration(NamedTuple):
    """Newton's iteration within a step: where it stands, and what it knows of the way there."""

    acceleration: jax.Array
    multipliers: jax.Array
    evaluated: ReachedState
    relative_residual: jax.Array
    """At the last evaluation"""
    sizes: jax.Array
    """(2,) of the residual at the last two evaluations, in parts of the tolerance"""
    moved: jax.Array
    """Largest change of a position by the last correction"""
    evaluations: jax.Array
    corrections: jax.Array
    converged: jax.Array
    predicted: jax.Array
    """Whether its end was accepted without an evaluation"""
    modified: Modified | None
    """None where every iterate has its own tangent"""


class Modified(NamedTuple):
    """What an iteration with a frozen tangent knows besides."""

    inverse: jax.Array
    """As in `FrozenTangent`"""
    own: jax.Array
    """Whether the last correction was made with a tangent of its own iterate"""
    made: jax.Array
    """Tangents in this step"""


class Assessed(NamedTuple):
    """What a pass makes of an evaluated iterate."""

    converged: jax.Array
    predicted: jax.Array
    """Whether the corrected one surely is"""
    change: jax.Array
    """Of the accelerations, (n,); zero of a converged iterate"""
    multiplier_change: jax.Array
    modified: Modified | None


def newton_pass(
    elimination: DenseElimination,
    model: Model,
    rule: StepRule,
    start: State,
    old: Iteration,
    trial: Trial,
    linearization: Linearization,
    size: jax.Array,
    stagnant: jax.Array,
) -> Assessed:
    """Newton's correction of an iterate that is not good enough.

    size : of its residual, in parts of the tolerance; stagnant : whether the last correction moved nothing
    """
    converged = trial.converged | stagnant
    trial = trial._replace(converged=converged)
    correct = _correction_where_needed if model.n_velocities < _FEWEST_IN_TURN else _correction_in_turn
    predicted = jnp.zeros((), dtype=bool)
    if is_predictable(model):
        predicted = (
            ~converged & (old.evaluations == 0) & predicted_to_converge(start.contraction, size, rule.h)
        )
    return Assessed(
        converged, predicted, *correct(elimination, model, rule, start, trial, linearization), None
    )


def _correction_where_needed(
    elimination: DenseElimination,
    model: Model,
    rule: StepRule,
    start: State,
    trial: Trial,
    linearization: Linearization,
) -> tuple[jax.Array, jax.Array]:
    """The next correction; none of a converged trial."""

    def corrected() -> tuple[jax.Array, jax.Array]:
        step = LinearizedStep(motion_of(rule, start, trial), linearization, trial.increments, rule.factors)
        change = correction(elimination, model, step, trial.residual, trial.constraint_residual)
        return change[: model.n_velocities], change[model.n_velocities :]

    return jax.lax.cond(
        trial.converged,
        lambda: (jnp.zeros_like(trial.acceleration), jnp.zeros_like(trial.multipliers)),
        corrected,
    )


def _correction_in_turn(
    elimination: DenseElimination, model: Model, rule: StepRule, start: State, *evaluated: Any
) -> tuple[jax.Array, jax.Array]:
    """The same for cases that take turns, each of which copies its numbers: tables of loads would be most."""
    held = model.loads_at(start.time + rule.h)
    return sequential_vmap(partial(_correction_where_needed, elimination), held, rule, start, *evaluated)


_FEWEST_IN_TURN = 16
"""Velocities of a system whose cases of a batch are corrected in turn: below, mapping them costs less."""
