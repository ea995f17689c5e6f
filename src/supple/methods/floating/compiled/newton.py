"""Newton's iteration within a step, with the exact tangent of every iterate."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp

from supple.equations.machine_model import Model
from supple.integrate import StepRule
from supple.methods.floating.compiled.contraction import is_predictable, predicted_to_converge
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.iterate import ReachedState, Trial, linearized
from supple.methods.floating.compiled.state import State
from supple.methods.floating.compiled.step_equations import correction

T = TypeVar("T")


class Iteration(NamedTuple):
    """State of Newton's iteration within a step."""

    acceleration: jax.Array
    multipliers: jax.Array
    evaluated: ReachedState
    relative_residual: jax.Array
    """Residuals at the last evaluation"""
    sizes: jax.Array
    """(2,) residuals at the last two evaluations, relative to the tolerance"""
    moved: jax.Array
    """Largest change of a position by the last correction"""
    evaluations: jax.Array
    corrections: jax.Array
    converged: jax.Array
    predicted: jax.Array
    """Whether the end was accepted without an evaluation"""
    modified: Modified | None
    """None where every iterate has its own tangent"""


class Modified(NamedTuple):
    """State of an iteration with a frozen tangent."""

    inverse: jax.Array
    """As in `FrozenInverse`"""
    own: jax.Array
    """Whether the last correction used the tangent of its own iterate"""
    made: jax.Array
    """Number of tangents in this step"""


class Assessed(NamedTuple):
    """Outcome of a pass over an evaluated iterate."""

    converged: jax.Array
    predicted: jax.Array
    """Whether the corrected iterate is predicted to converge"""
    change: jax.Array
    """(n,) correction of the accelerations; zero for a converged iterate"""
    multiplier_change: jax.Array
    modified: Modified | None


def newton_pass(
    elimination: DenseElimination,
    model: Model,
    rule: StepRule,
    start: State,
    old: Iteration,
    trial: Trial,
    size: jax.Array,
    stagnant: jax.Array,
) -> Assessed:
    """Newton's correction of an iterate that has not converged.

    size : residual relative to the tolerance; stagnant : whether the last correction changed nothing
    """
    converged = trial.converged | stagnant
    trial = trial._replace(converged=converged)
    one_by_one = model.n_velocities >= _FEWEST_SEQUENTIAL and jax.default_backend() == "cpu"
    correct = partial(_correction_where_needed, elimination)
    if one_by_one:  # loads are evaluated before, as arguments are copied
        held = model.loads_at(start.time + rule.h)
        changes = sequential_vmap(correct, held, rule, start, trial)
    else:
        changes = correct(model, rule, start, trial)
    predicted = jnp.zeros((), dtype=bool)
    if is_predictable(model):
        predicted = (
            ~converged & (old.evaluations == 0) & predicted_to_converge(start.contraction, size, rule.h)
        )
    return Assessed(converged, predicted, *changes, None)


def _correction_where_needed(
    elimination: DenseElimination,
    model: Model,
    rule: StepRule,
    start: State,
    trial: Trial,
) -> tuple[jax.Array, jax.Array]:
    """The next correction; zero for a converged trial."""

    def corrected() -> tuple[jax.Array, jax.Array]:
        step = linearized(rule, start, trial)
        change = correction(elimination, model, step, trial.residual, trial.constraint_residual)
        return change[: model.n_velocities], change[model.n_velocities :]

    return jax.lax.cond(
        trial.converged,
        lambda: (jnp.zeros_like(trial.acceleration), jnp.zeros_like(trial.multipliers)),
        corrected,
    )


def sequential_vmap(function: Callable[..., T], *arguments: object) -> T:
    """`function(*arguments)`; under `jax.vmap` the cases are computed one after the other.

    A condition then stays a branch for each case, whereas mapped cases all compute both sides. Many small
    operations cost as little as in a program of one case.
    """
    leaves, structure = jax.tree.flatten(arguments)

    # Leaf by leaf: classes that check their fields do not accept the flags that JAX would put in their place.
    @jax.custom_batching.sequential_vmap
    def of_leaves(each: list[jax.Array]) -> T:
        return function(*structure.unflatten(each))

    return of_leaves([jnp.asarray(leaf) for leaf in leaves])


_FEWEST_SEQUENTIAL = 16
"""Number of velocities from which a CPU corrects the cases of a batch one after the other, not mapped."""
