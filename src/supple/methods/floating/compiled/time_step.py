"""One compiled time step, and the time integration between output times.

The unknowns are the new accelerations and multipliers. Newton's iteration (`newton`) solves for them, or the
modified Newton iteration (`modified_newton`) where the tangent is frozen.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeVar

import jax
import jax.numpy as jnp

from supple.equations.control_force import stepped
from supple.equations.coordinate_scales import position_scale
from supple.equations.machine_model import Model
from supple.equations.step_size import next_step, position_rounding
from supple.integrate import StepRule
from supple.methods.floating.compiled.contraction import is_predictable, new_contraction
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.frozen_tangent import predicted
from supple.methods.floating.compiled.iterate import ReachedState, evaluate, motion_of, place
from supple.methods.floating.compiled.modified_newton import modified_pass, used_in_step
from supple.methods.floating.compiled.newton import Iteration, Modified, newton_pass
from supple.methods.floating.compiled.state import Controls, State

C = TypeVar("C")
Shown = TypeVar("Shown")


def _try_step(
    elimination: DenseElimination, model: Model, controls: Controls, start: State, h: jax.Array
) -> tuple[Iteration, ReachedState]:
    """The iteration for one step of size h, from the acceleration of its start or an extrapolated one.

    Each pass evaluates the residual of the current iterate and, unless it has converged, computes the next
    iterate: the compiled program contains the code of both only once. The iteration ends with an iterate that
    has converged, or that is predicted to.
    """
    rule = StepRule(controls.coefficients, h)
    scale = position_scale(model)
    newton = newton_pass if start.kept is None else modified_pass

    def unfinished(old: Iteration) -> jax.Array:
        finite = jnp.all(jnp.isfinite(old.relative_residual))
        return ~(old.converged | old.predicted) & finite & (old.evaluations <= controls.max_iterations)

    def one_pass(old: Iteration) -> Iteration:
        tolerance = controls.residual_tolerance
        trial = evaluate(model, rule, start, old.acceleration, old.multipliers, tolerance)
        # Below rounding error, residuals do not distinguish better iterates from worse ones.
        rounding = position_rounding(model.length, trial.configuration.origins)
        stagnant = (old.evaluations > 0) & (old.moved <= rounding) & (trial.relative_residual[3] <= 1e-6)
        size = jnp.max(trial.relative_residual) / tolerance
        found = newton(elimination, model, rule, start, old, trial, size, stagnant)
        return Iteration(
            acceleration=old.acceleration + found.change,
            multipliers=old.multipliers + found.multiplier_change,
            evaluated=ReachedState(trial.configuration, trial.velocity, trial.increments),
            relative_residual=trial.relative_residual,
            sizes=jnp.stack([old.sizes[1], size]),
            moved=rule.factors.by_position * jnp.max(jnp.abs(found.change) / scale),
            evaluations=old.evaluations + 1,
            corrections=old.evaluations + found.predicted,
            converged=found.converged,
            predicted=found.predicted,
            modified=found.modified,
        )

    none, never = jnp.zeros((), dtype=int), jnp.zeros((), dtype=bool)
    first, modified = start.acceleration, None
    if start.kept is not None:
        first = predicted(start.kept, first, h)
        modified = Modified(start.kept.inverse, never, none)
    end = jax.lax.while_loop(
        unfinished,
        one_pass,
        Iteration(
            acceleration=first,
            multipliers=start.multipliers,
            evaluated=ReachedState(start.configuration, start.velocity, jnp.zeros_like(start.velocity)),
            relative_residual=jnp.zeros(4),
            sizes=jnp.zeros(2),
            moved=jnp.zeros(()),
            evaluations=none,
            corrections=none,
            converged=never,
            predicted=never,
            modified=modified,
        ),
    )
    if not is_predictable(model):
        return end, end.evaluated
    placed = jax.lax.cond(
        end.predicted, lambda: place(model, rule, start, end.acceleration), lambda: end.evaluated
    )
    return end, placed


def equal_steps(start: State, end: jax.Array) -> jax.Array:
    """Number of equal steps up to a stop; rounding of the quotient, up to 1e-9, adds no step."""
    return jnp.maximum(jnp.ceil((end - start.time) / start.step * (1 - 1e-9)), 1.0)


def is_last(h: jax.Array, remaining: jax.Array) -> jax.Array:
    """Whether a step of size h ends at the stop."""
    return h >= remaining * (1 - 1e-9)


def substep(
    elimination: DenseElimination, model: Model, controls: Controls, end: jax.Array, start: State
) -> State:
    """Try one step towards `end`: accept it, or reduce its size."""
    remaining = end - start.time
    h = remaining / equal_steps(start, end)
    iteration, placed = _try_step(elimination, model, controls, start, h)
    rule = StepRule(controls.coefficients, h)
    auxiliary = rule.auxiliary(iteration.acceleration, start.acceleration, start.auxiliary)
    error = jnp.max(jnp.abs(rule.position_error(start.auxiliary, auxiliary) / position_scale(model)))
    converged = (iteration.converged | iteration.predicted) & jnp.isfinite(error)
    accepted = converged & (error <= controls.error_tolerance)

    proposed = next_step(h, start.step, error, controls.error_tolerance, controls.largest)
    proposed = jnp.where(converged, proposed, h / 2)
    failed = ~accepted & (proposed < controls.smallest)
    last, turns = is_last(h, remaining), model.frames.take(placed.increments)[:, 3:]
    contraction = new_contraction(
        start.contraction, iteration.sizes, h, iteration.corrections, iteration.converged
    )
    kept = None
    if start.kept is not None:
        contraction, kept = used_in_step(model, start, h, iteration, contraction)
    after = State(
        time=jnp.where(last, end, start.time + h),
        step=proposed,
        configuration=placed.configuration,
        velocity=placed.velocity,
        acceleration=iteration.acceleration,
        auxiliary=auxiliary,
        multipliers=iteration.multipliers,
        steps=start.steps + 1,
        iterations=start.iterations + iteration.corrections,
        rejected_steps=start.rejected_steps,
        failed=failed,
        relative_residual=iteration.relative_residual,
        contraction=contraction,
        largest_error=jnp.maximum(start.largest_error, error),
        largest_turn=jnp.maximum(start.largest_turn, jnp.sqrt(jnp.max(jnp.sum(turns**2, axis=1)))),
        kept=kept,
    )
    after = after._replace(control=stepped(model, motion_of(rule, start, after)))
    before = start._replace(
        step=proposed,
        iterations=start.iterations + iteration.corrections,
        rejected_steps=start.rejected_steps + 1,
        failed=failed,
        relative_residual=iteration.relative_residual,
    )
    return jax.tree.map(lambda a, b: jnp.where(accepted, a, b), after, before)


def through_stops(
    begun: C, stops: jax.Array, to_stop: Callable[[jax.Array, C], C], shown: Callable[[C], Shown]
) -> tuple[C, Shown]:
    """Integrate to each of the stops (k,), ascending; the end, and what is `shown` at the stops, stacked.

    to_stop : integration to the stop of a number
    Integration ends before the first stop that repeats the previous one; the rows from there on are zero.
    """
    begun = jax.tree.map(jnp.asarray, begun)
    rows = jax.tree.map(lambda leaf: jnp.zeros((len(stops), *leaf.shape), leaf.dtype), shown(begun))

    def unfinished(march: tuple[jax.Array, C, Shown]) -> jax.Array:
        row = march[0]
        return (row < len(stops)) & ((row == 0) | (stops[row] > stops[row - 1]))

    def one(march: tuple[jax.Array, C, Shown]) -> tuple[jax.Array, C, Shown]:
        row, now, every = march
        now = to_stop(row, now)
        every = jax.tree.map(
            lambda rows, own: jax.lax.dynamic_update_index_in_dim(rows, own, row, 0), every, shown(now)
        )
        return row + 1, now, every

    return jax.lax.while_loop(unfinished, one, (jnp.asarray(0), begun, rows))[1:]


def march(
    elimination: DenseElimination, model: Model, controls: Controls, start: State, stops: jax.Array
) -> tuple[State, State]:
    """Integrate to each of the stops (k,), ascending; the final state, and the stacked states at the stops.

    After a failed step the state does not change any more: the caller must check `failed`.
    """

    def to_stop(row: jax.Array, state: State) -> State:
        return jax.lax.while_loop(
            lambda s: (s.time < stops[row]) & ~s.failed,
            partial(substep, elimination, model, controls, stops[row]),
            state,
        )

    return through_stops(start, stops, to_stop, lambda state: state._replace(kept=None))
