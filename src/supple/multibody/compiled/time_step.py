"""One compiled time step, and the march from output time to output time.

Unknown are the new accelerations and multipliers, which Newton's iteration finds (`step_equations`).
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from supple.integrate import Coefficients, StepRule
from supple.multibody.compiled.contraction import (
    Contraction,
    foretold_to_converge,
    is_foretellable,
    measured,
)
from supple.multibody.compiled.in_turn import in_turn
from supple.multibody.compiled.step_equations import LinearizedStep, correction, kinds_of_rows
from supple.multibody.equations.balance import Balance, Linearization, balance
from supple.multibody.equations.configuration import (
    AnyArray,
    Configuration,
    ControlState,
    ControlStep,
    SystemMotion,
    advance,
)
from supple.multibody.equations.control_force import stepped
from supple.multibody.equations.model import BodyGroup, Model
from supple.multibody.equations.places import Places, assembled_vector
from supple.multibody.equations.step_size import next_step, position_rounding

__all__ = ["Controls", "State", "march", "position_scale", "substep"]


class Controls(NamedTuple):
    """Numbers that steer a run; plain floats, so that changing one compiles nothing anew."""

    coefficients: Coefficients
    first: Any
    largest: Any
    smallest: Any
    error_tolerance: Any
    residual_tolerance: Any
    max_iterations: Any


class State(NamedTuple):
    """Everything needed to go on from an instant."""

    time: AnyArray
    step: AnyArray
    """Size of the next step to try."""
    configuration: Configuration
    velocity: AnyArray
    acceleration: AnyArray
    auxiliary: AnyArray
    """Auxiliary acceleration of the Newmark family."""
    multipliers: AnyArray
    steps: AnyArray
    iterations: AnyArray
    rejected_steps: AnyArray
    failed: AnyArray
    """True when the smallest step did not converge: the state is that before the step."""
    relative_residual: AnyArray
    """Relative residual at the last evaluation, by kind: force, moment, deformation, constraint."""
    contraction: Contraction
    largest_error: AnyArray
    """Largest local error of an accepted step so far."""
    largest_turn: AnyArray
    """Largest rotation of a body within an accepted step so far, rad."""
    control: ControlState | None = None
    """None where there are no controllers"""


class _Trial(NamedTuple):
    """An evaluated iterate within a step."""

    acceleration: jax.Array
    multipliers: jax.Array
    configuration: Configuration
    velocity: jax.Array
    increments: jax.Array
    residual: jax.Array
    constraint_residual: jax.Array
    relative_residual: jax.Array
    converged: jax.Array


class _Place(NamedTuple):
    """Where an acceleration leads."""

    configuration: Configuration
    velocity: Any
    increments: Any


class _Iteration(NamedTuple):
    """Newton's iteration within a step: where it stands, and what it knows of the way there."""

    acceleration: jax.Array
    multipliers: jax.Array
    evaluated: _Place
    relative_residual: jax.Array
    """At the last evaluation"""
    sizes: jax.Array
    """(2,) of the residual at the last two evaluations, in parts of the tolerance"""
    moved: jax.Array
    """Largest change of a position by the last correction"""
    evaluations: jax.Array
    corrections: jax.Array
    converged: jax.Array
    foretold: jax.Array
    """Whether its end was accepted without an evaluation"""


class _Stepped(NamedTuple):
    """Where Newton's iteration ended."""

    acceleration: jax.Array
    multipliers: jax.Array
    auxiliary: jax.Array
    configuration: Configuration
    velocity: jax.Array
    increments: jax.Array
    iteration: _Iteration


def position_scale(model: Model) -> jax.Array:
    """What counts as a large change of each freedom, (n,)."""

    def of_group(group: BodyGroup) -> tuple[Places, jax.Array]:
        k = len(group.members)
        deformation = jnp.broadcast_to(jnp.asarray(group.coordinate_scale)[:, None], (k, group.r))
        frames = (jnp.full((k, 3), model.length), jnp.ones((k, 3)))
        return group.velocities, jnp.concatenate([*frames, deformation], axis=1)

    return assembled_vector(model.n_velocities, [of_group(group) for group in model.groups])


def _relative(norm: jax.Array, scale: jax.Array) -> jax.Array:
    """`norm / scale`, and 0 where nothing is out of balance."""
    # Asked this way round, NaN stays NaN: no comparison with it holds.
    return jnp.where(norm == 0, 0.0, norm / jnp.where(scale > 0, scale, 1.0))


def _relative_residual(
    model: Model, terms: Balance, trial: jax.Array, position: jax.Array, rounding: jax.Array
) -> jax.Array:
    """Residual of each kind over the largest term in balance, and the constraints' over the accelerations."""
    columns = (terms.residual, terms.inertia, terms.internal, terms.applied, terms.joint)
    norms = jnp.sqrt(kinds_of_rows(model) @ jnp.stack(columns, axis=1) ** 2)
    forces = _relative(norms[:, 0], jnp.max(norms[:, 1:], axis=1))
    accelerations = model.length * jnp.max(jnp.abs(trial / position_scale(model)), initial=0.0)
    largest_gap = jnp.max(jnp.abs(terms.constraint_residual), initial=0.0)
    floor = rounding * model.length
    constraint = jnp.where(
        largest_gap <= floor, 0.0, _relative(largest_gap / position, accelerations + floor / position)
    )
    return jnp.concatenate([forces, constraint[None]])


def _place(model: Model, rule: StepRule, start: State, acceleration: jax.Array) -> _Place:
    """Configuration, velocity and increments that belong to an acceleration."""
    auxiliary = rule.auxiliary(acceleration, start.acceleration, start.auxiliary)
    increments = rule.increment(start.velocity, start.auxiliary, auxiliary)
    velocity = rule.new_velocity(start.velocity, start.auxiliary, auxiliary)
    return _Place(advance(model, start.configuration, increments), velocity, increments)


def _evaluate(
    model: Model,
    rule: StepRule,
    start: State,
    acceleration: jax.Array,
    multipliers: jax.Array,
    tolerance: jax.Array,
) -> tuple[_Trial, Linearization]:
    configuration, velocity, increments = _place(model, rule, start, acceleration)
    time = start.time + rule.h
    control = _control(start, rule)
    terms = balance(model, SystemMotion(time, configuration, velocity, acceleration, multipliers, control))
    rounding = position_rounding(model.length, configuration.origins)
    relative_residual = _relative_residual(model, terms, acceleration, rule.factors.by_position, rounding)
    trial = _Trial(
        acceleration,
        multipliers,
        configuration,
        velocity,
        increments,
        terms.residual,
        terms.constraint_residual,
        relative_residual,
        jnp.all(relative_residual <= tolerance),
    )
    return trial, terms.linearization


def _control(start: State, rule: StepRule) -> ControlStep | None:
    return None if start.control is None else ControlStep(start.control, rule.h)


def _motion(rule: StepRule, start: State, trial: _Trial | _Stepped) -> SystemMotion:
    """What the equations are evaluated at, of an iterate."""
    return SystemMotion(
        start.time + rule.h,
        trial.configuration,
        trial.velocity,
        trial.acceleration,
        trial.multipliers,
        _control(start, rule),
    )


def _newton_correction(
    model: Model, rule: StepRule, start: State, trial: _Trial, linearization: Linearization
) -> tuple[jax.Array, jax.Array]:
    motion = _motion(rule, start, trial)
    step = LinearizedStep(motion, linearization, trial.increments, rule.factors)
    change = correction(model, step, trial.residual, trial.constraint_residual)
    n = model.n_velocities
    return change[:n], change[n:]


def _correction_where_needed(
    model: Model, rule: StepRule, start: State, trial: _Trial, linearization: Linearization
) -> tuple[jax.Array, jax.Array]:
    """The next correction; none of a converged trial."""
    return jax.lax.cond(
        trial.converged,
        lambda: (jnp.zeros_like(trial.acceleration), jnp.zeros_like(trial.multipliers)),
        lambda: _newton_correction(model, rule, start, trial, linearization),
    )


def _correction_in_turn(
    model: Model, rule: StepRule, start: State, trial: _Trial, linearization: Linearization
) -> tuple[jax.Array, jax.Array]:
    """The same for cases that take turns, each of which copies its numbers: tables of loads would be most."""
    held = model.loads_at(start.time + rule.h)
    return in_turn(_correction_where_needed, held, rule, start, trial, linearization)


_FEWEST_IN_TURN = 16
"""Velocities of a system whose cases of a batch are corrected in turn: below, mapping them costs less."""


def _try_step(model: Model, controls: Controls, start: State, h: jax.Array) -> _Stepped:
    """Newton's iteration for one step of size h from the constant-acceleration guess.

    Each pass evaluates the residual at the iterate left by the pass before and, unless that is good enough,
    finds the next one; so the code for either stands once in the compiled program. It ends with an iterate
    that is good, or with one that surely will be.
    """
    rule = StepRule(controls.coefficients, h)
    scale = position_scale(model)
    correction = _correction_where_needed if model.n_velocities < _FEWEST_IN_TURN else _correction_in_turn

    def unfinished(old: _Iteration) -> jax.Array:
        finite = jnp.all(jnp.isfinite(old.relative_residual))
        return ~(old.converged | old.foretold) & finite & (old.evaluations <= controls.max_iterations)

    def one_pass(old: _Iteration) -> _Iteration:
        tolerance = controls.residual_tolerance
        trial, linearization = _evaluate(model, rule, start, old.acceleration, old.multipliers, tolerance)
        # Below rounding error no residual can tell a better answer from a worse one.
        rounding = position_rounding(model.length, trial.configuration.origins)
        settled = (old.evaluations > 0) & (old.moved <= rounding) & (trial.relative_residual[3] <= 1e-6)
        trial = trial._replace(converged=trial.converged | settled)
        change, multiplier_change = correction(model, rule, start, trial, linearization)
        size = jnp.max(trial.relative_residual) / tolerance
        foretold = jnp.zeros((), dtype=bool)
        if is_foretellable(model):
            foretold = ~trial.converged & (old.evaluations == 0)
            foretold = foretold & foretold_to_converge(start.contraction, size, h)
        return _Iteration(
            acceleration=old.acceleration + change,
            multipliers=old.multipliers + multiplier_change,
            evaluated=_Place(trial.configuration, trial.velocity, trial.increments),
            relative_residual=trial.relative_residual,
            sizes=jnp.stack([old.sizes[1], size]),
            moved=rule.factors.by_position * jnp.max(jnp.abs(change) / scale),
            evaluations=old.evaluations + 1,
            corrections=old.evaluations + foretold,
            converged=trial.converged,
            foretold=foretold,
        )

    none, never = jnp.zeros((), dtype=int), jnp.zeros((), dtype=bool)
    end = jax.lax.while_loop(
        unfinished,
        one_pass,
        _Iteration(
            acceleration=start.acceleration,
            multipliers=start.multipliers,
            evaluated=_Place(start.configuration, start.velocity, jnp.zeros_like(start.velocity)),
            relative_residual=jnp.zeros(4),
            sizes=jnp.zeros(2),
            moved=jnp.zeros(()),
            evaluations=none,
            corrections=none,
            converged=never,
            foretold=never,
        ),
    )
    place = end.evaluated
    if is_foretellable(model):
        place = jax.lax.cond(
            end.foretold, lambda: _place(model, rule, start, end.acceleration), lambda: end.evaluated
        )
    auxiliary = rule.auxiliary(end.acceleration, start.acceleration, start.auxiliary)
    return _Stepped(
        acceleration=end.acceleration,
        multipliers=end.multipliers,
        auxiliary=auxiliary,
        configuration=place.configuration,
        velocity=place.velocity,
        increments=place.increments,
        iteration=end,
    )


def _local_error(model: Model, rule: StepRule, start: State, trial: _Stepped) -> jax.Array:
    error = rule.position_error(start.auxiliary, trial.auxiliary) / position_scale(model)
    return jnp.max(jnp.abs(error))


def _turn(model: Model, increments: jax.Array) -> jax.Array:
    """Largest rotation of a body within a step, rad."""
    turns = model.frames.take(increments)[:, 3:]
    return jnp.sqrt(jnp.max(jnp.sum(turns**2, axis=1)))


def substep(model: Model, controls: Controls, end: jax.Array, start: State) -> State:
    """Try one step towards `end`: accept it, or cut it."""
    remaining = end - start.time
    # A whole number of equal steps to the output time; 1e-9 forgives the rounding of their quotient.
    h = remaining / jnp.maximum(jnp.ceil(remaining / start.step * (1 - 1e-9)), 1.0)
    trial = _try_step(model, controls, start, h)
    iteration = trial.iteration
    error = _local_error(model, StepRule(controls.coefficients, h), start, trial)
    converged = (iteration.converged | iteration.foretold) & jnp.isfinite(error)
    accepted = converged & (error <= controls.error_tolerance)

    proposed = next_step(h, start.step, error, controls.error_tolerance, controls.largest)
    proposed = jnp.where(converged, proposed, h / 2)
    failed = ~accepted & (proposed < controls.smallest)
    last = h >= remaining * (1 - 1e-9)
    after = State(
        time=jnp.where(last, end, start.time + h),
        step=proposed,
        configuration=trial.configuration,
        velocity=trial.velocity,
        acceleration=trial.acceleration,
        auxiliary=trial.auxiliary,
        multipliers=trial.multipliers,
        steps=start.steps + 1,
        iterations=start.iterations + iteration.corrections,
        rejected_steps=start.rejected_steps,
        failed=failed,
        relative_residual=iteration.relative_residual,
        contraction=measured(
            start.contraction, iteration.sizes, h, iteration.corrections, iteration.converged
        ),
        largest_error=jnp.maximum(start.largest_error, error),
        largest_turn=jnp.maximum(start.largest_turn, _turn(model, trial.increments)),
        control=stepped(model, _motion(StepRule(controls.coefficients, h), start, trial)),
    )
    before = start._replace(
        step=proposed,
        iterations=start.iterations + iteration.corrections,
        rejected_steps=start.rejected_steps + 1,
        failed=failed,
        relative_residual=iteration.relative_residual,
    )
    return jax.tree.map(lambda a, b: jnp.where(accepted, a, b), after, before)


def march(model: Model, controls: Controls, start: State, stops: jax.Array) -> tuple[State, State]:
    """Simulate to each of the stops (k,), ascending; the final state, and the states there, stacked.

    It ends with the first stop that repeats the one before; the rows behind it are zero. After a failure the
    state stays where it was: the caller looks at `failed`.
    """
    rows = jax.tree.map(lambda leaf: jnp.zeros((len(stops), *jnp.shape(leaf)), jnp.result_type(leaf)), start)

    def unfinished(march: tuple[jax.Array, State, State]) -> jax.Array:
        row = march[0]
        return (row < len(stops)) & ((row == 0) | (stops[row] > stops[row - 1]))

    def to_stop(march: tuple[jax.Array, State, State]) -> tuple[jax.Array, State, State]:
        row, state, states = march
        state = jax.lax.while_loop(
            lambda s: (s.time < stops[row]) & ~s.failed,
            partial(substep, model, controls, stops[row]),
            state,
        )
        states = jax.tree.map(
            lambda every, own: jax.lax.dynamic_update_index_in_dim(every, own, row, 0), states, state
        )
        return row + 1, state, states

    start = jax.tree.map(jnp.asarray, start)
    return jax.lax.while_loop(unfinished, to_stop, (jnp.asarray(0), start, rows))[1:]
