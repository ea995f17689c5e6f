"""Lines marched through output times by one compiled program."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree

from supple.integrate import GeneralizedAlpha, ResidualRungeKutta4, RungeKutta4
from supple.intrinsic.implicit_step import first_order_coefficients, implicit_step
from supple.intrinsic.line_system import LineSystem, States, system_rates
from supple.intrinsic.residual_modes import at_rest_rates, slaved
from supple.intrinsic.runge_kutta import runge_kutta_step

__all__ = ["LineRule", "MarchState", "first_march_state", "march_lines"]

LineRule = RungeKutta4 | ResidualRungeKutta4 | GeneralizedAlpha
"""Step rules that lines take; GeneralizedAlpha(1.0) keeps the energy."""


class MarchState(NamedTuple):
    """Where a march is.

    rates : (N,)        of all states in one vector, that the implicit rule remembers; empty for the others
    worst : ()          the largest contraction of residual modes, or residual of an implicit step, so far
    iterations : ()     of implicit steps, so far
    """

    time: Any
    states: States
    rates: Any
    worst: Any
    iterations: Any


def first_march_state(system: LineSystem, rule: LineRule, time: float, states: States) -> MarchState:
    """The state in which a march begins."""
    none, count = jnp.zeros(()), jnp.zeros((), dtype=int)
    if isinstance(rule, GeneralizedAlpha):
        rates = ravel_pytree(jax.jit(system_rates)(system, time, states))[0]
        return MarchState(jnp.asarray(float(time)), states, rates, none, count)
    if isinstance(rule, ResidualRungeKutta4):
        states, _ = slaved(system, _kept(system, rule), time, states, 3 * rule.sweeps)
    return MarchState(jnp.asarray(float(time)), states, jnp.zeros(0), none, count)


@partial(jax.jit, static_argnames=("rule", "n_steps", "max_iterations"))
def march_lines(
    system: LineSystem,
    start: MarchState,
    times: jax.Array,
    *,
    rule: LineRule,
    n_steps: int,
    tolerance: Any = 1e-10,
    max_iterations: int = 12,
) -> MarchState:
    """The states at output times (t,), each reached in `n_steps` equal steps; leaves have a leading axis.

    It can be mapped over cases (`jax.vmap`) and differentiated; explicit rules in either direction, the
    implicit one forwards.
    """
    step = _step_of(system, rule, tolerance, max_iterations)

    def to_output(state: MarchState, end: jax.Array) -> tuple[MarchState, MarchState]:
        h = (end - state.time) / n_steps
        begin = state.time

        def one(now: MarchState, number: jax.Array) -> tuple[MarchState, None]:
            return step(now._replace(time=begin + number * h), h), None

        last, _ = jax.lax.scan(one, state, jnp.arange(n_steps))
        last = last._replace(time=end)
        return last, last

    return jax.lax.scan(to_output, start, times)[1]


def _step_of(
    system: LineSystem, rule: LineRule, tolerance: Any, max_iterations: int
) -> Callable[[MarchState, Any], MarchState]:
    match rule:
        case RungeKutta4():
            return lambda now, h: now._replace(
                states=runge_kutta_step(lambda t, y: system_rates(system, t, y), now.time, now.states, h)
            )
        case ResidualRungeKutta4():
            return partial(_residual_step, system, rule)
        case GeneralizedAlpha():
            return partial(_implicit, system, rule, tolerance, max_iterations)


def _kept(system: LineSystem, rule: ResidualRungeKutta4) -> tuple[int, ...]:
    return tuple(min(rule.n_kept, model.velocities.shape[1]) for model in system.lines)


def _residual_step(system: LineSystem, rule: ResidualRungeKutta4, now: MarchState, h: Any) -> MarchState:
    kept = _kept(system, rule)

    def rates(time: Any, states: States) -> States:
        following, _ = slaved(system, kept, time, states, rule.sweeps)
        return at_rest_rates(kept, system, system_rates(system, time, following))

    moved = runge_kutta_step(rates, now.time, now.states, h)
    states, contraction = slaved(system, kept, now.time + h, moved, rule.sweeps)
    return now._replace(states=states, worst=jnp.maximum(now.worst, contraction))


def _implicit(
    system: LineSystem, rule: GeneralizedAlpha, tolerance: Any, most: int, now: MarchState, h: Any
) -> MarchState:
    flat, unravel = ravel_pytree(now.states)

    def rates(time: Any, y: jax.Array) -> jax.Array:
        return ravel_pytree(system_rates(system, time, unravel(y)))[0]

    coefficients = first_order_coefficients(rule.rho_inf)
    done = implicit_step(rates, coefficients, now.time, flat, now.rates, h, tolerance=tolerance, most=most)
    return MarchState(
        now.time,
        unravel(done.state),
        done.rates,
        jnp.maximum(now.worst, done.residual),
        now.iterations + done.iterations,
    )
