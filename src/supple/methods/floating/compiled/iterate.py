"""An iterate of a step: the motion that follows from an acceleration, and its residual."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.arrays import AnyArray
from supple.equations.balance import Balance, Linearization, balance
from supple.equations.configuration import Configuration, ControlStep, SystemMotion, advance
from supple.equations.coordinate_scales import kinds_of_rows, position_scale
from supple.equations.machine_model import Model
from supple.equations.step_size import position_rounding
from supple.integrate import StepRule
from supple.methods.floating.compiled.state import State
from supple.methods.floating.compiled.step_equations import LinearizedStep


class Trial(NamedTuple):
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
    linearization: Linearization


class ReachedState(NamedTuple):
    """Configuration and velocities that follow from an acceleration."""

    configuration: Configuration
    velocity: AnyArray
    increments: AnyArray


def _relative(norm: jax.Array, scale: jax.Array) -> jax.Array:
    """`norm / scale`, and 0 where the norm is zero."""
    # With this comparison NaN stays NaN: every comparison with NaN is false.
    return jnp.where(norm == 0, 0.0, norm / jnp.where(scale > 0, scale, 1.0))


def _relative_residual(
    model: Model, terms: Balance, trial: jax.Array, position: jax.Array, rounding: jax.Array
) -> jax.Array:
    """Residual of each kind relative to its largest term, constraints relative to the accelerations."""
    columns = (terms.residual, terms.inertia, terms.internal, terms.applied, terms.joint)
    norms = jnp.sqrt(kinds_of_rows(model) @ jnp.stack(columns, axis=1) ** 2)
    forces = _relative(norms[:, 0], jnp.max(norms[:, 1:], axis=1))
    accelerations = model.length * jnp.max(jnp.abs(trial / position_scale(model)), initial=0.0)
    largest_gap = jnp.max(jnp.abs(model.as_lengths(terms.constraint_residual)), initial=0.0)
    floor = rounding * model.length
    constraint = jnp.where(
        largest_gap <= floor, 0.0, _relative(largest_gap / position, accelerations + floor / position)
    )
    return jnp.concatenate([forces, constraint[None]])


def place(model: Model, rule: StepRule, start: State, acceleration: jax.Array) -> ReachedState:
    """Configuration, velocity and increments that follow from an acceleration."""
    auxiliary = rule.auxiliary(acceleration, start.acceleration, start.auxiliary)
    increments = rule.increment(start.velocity, start.auxiliary, auxiliary)
    velocity = rule.new_velocity(start.velocity, start.auxiliary, auxiliary)
    return ReachedState(advance(model, start.configuration, increments), velocity, increments)


def evaluate(
    model: Model,
    rule: StepRule,
    start: State,
    acceleration: jax.Array,
    multipliers: jax.Array,
    tolerance: jax.Array,
) -> Trial:
    """Residuals of accelerations (n,) and multipliers (m,), and their linearisation."""
    configuration, velocity, increments = place(model, rule, start, acceleration)
    time = start.time + rule.h
    control = _control(start, rule)
    terms = balance(model, SystemMotion(time, configuration, velocity, acceleration, multipliers, control))
    rounding = position_rounding(model.length, configuration.origins)
    relative_residual = _relative_residual(model, terms, acceleration, rule.factors.by_position, rounding)
    return Trial(
        acceleration,
        multipliers,
        configuration,
        velocity,
        increments,
        terms.residual,
        terms.constraint_residual,
        relative_residual,
        jnp.all(relative_residual <= tolerance),
        terms.linearization,
    )


def _control(start: State, rule: StepRule) -> ControlStep | None:
    return None if start.control is None else ControlStep(start.control, rule.h)


def motion_of(rule: StepRule, start: State, at: Trial | State) -> SystemMotion:
    """Motion at which the equations are evaluated, for an iterate or for the end of a step."""
    return SystemMotion(
        start.time + rule.h,
        at.configuration,
        at.velocity,
        at.acceleration,
        at.multipliers,
        _control(start, rule),
    )


def linearized(rule: StepRule, start: State, trial: Trial) -> LinearizedStep:
    """Point of linearisation of an iterate."""
    motion = motion_of(rule, start, trial)
    return LinearizedStep(motion, trial.linearization, trial.increments, rule.factors)
