"""Time integration of lines through output times by one compiled program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jax.tree_util import register_static

from supple.integrate import GeneralizedAlpha, ResidualRungeKutta4, RungeKutta4
from supple.methods.intrinsic.implicit_step import (
    Tangent,
    first_order_coefficients,
    first_tangent,
    implicit_step,
)
from supple.methods.intrinsic.line_slope import system_slope
from supple.methods.intrinsic.line_system import LineSystem, States, system_rates
from supple.methods.intrinsic.residual_modes import at_rest_rates, inverse_of_high, slaved
from supple.programs.program_cache import CachedProgram

__all__ = [
    "LineMarchState",
    "LineRule",
    "Stepping",
    "compiled_march",
    "first_march_state",
    "march_lines",
    "runge_kutta_step",
]

LineRule = RungeKutta4 | ResidualRungeKutta4 | GeneralizedAlpha
"""Step rules for lines; GeneralizedAlpha(1.0) conserves energy."""


class LineMarchState(NamedTuple):
    """State of a time integration of lines.

    rates : (N,)        rates of all states in one vector, for the implicit rule; empty for other rules
    worst : ()          largest contraction of residual modes, or residual of a step, since the start
    iterations : ()     iterations of implicit steps since the start
    """

    time: Any
    states: States
    rates: Any
    worst: Any
    iterations: Any


_rates = CachedProgram(system_rates)


def first_march_state(system: LineSystem, rule: LineRule, time: float, states: States) -> LineMarchState:
    """The initial state of a time integration."""
    none, count = jnp.zeros(()), jnp.zeros((), dtype=int)
    if isinstance(rule, GeneralizedAlpha):
        rates = ravel_pytree(_rates(system, time, states))[0]
        return LineMarchState(jnp.asarray(float(time)), states, rates, none, count)
    if isinstance(rule, ResidualRungeKutta4):
        states, _ = slaved(system, _kept(system, rule), time, states, 3 * rule.sweeps)
    return LineMarchState(jnp.asarray(float(time)), states, jnp.zeros(0), none, count)


@register_static
@dataclass(frozen=True)
class Stepping:
    """Static arguments of `march_lines`: step rule, steps to an output time, iterations of a step at most."""

    rule: LineRule
    n_steps: int
    max_iterations: int = 12


def march_lines(
    stepping: Stepping,
    system: LineSystem,
    start: LineMarchState,
    times: jax.Array,
    tolerance: jax.Array | float = 1e-10,
) -> LineMarchState:
    """The states at output times (t,), each reached in equal steps; leaves have a leading axis.

    The function can be mapped over cases (`jax.vmap`), and differentiated in forward and reverse mode.
    """
    n_steps = stepping.n_steps
    step = _step_of(system, stepping, tolerance)
    tangent = first_tangent(start.rates.size) if isinstance(stepping.rule, GeneralizedAlpha) else None

    def to_output(
        carry: tuple[LineMarchState, Any], end: jax.Array
    ) -> tuple[tuple[LineMarchState, Any], LineMarchState]:
        state, known = carry
        h = (end - state.time) / n_steps
        begin = state.time

        def one(
            now: tuple[LineMarchState, Any], number: jax.Array
        ) -> tuple[tuple[LineMarchState, Any], None]:
            return step(now[0]._replace(time=begin + number * h), now[1], h), None

        (last, known), _ = jax.lax.scan(one, (state, known), jnp.arange(n_steps))
        last = last._replace(time=end)
        return (last, known), last

    return jax.lax.scan(to_output, (start, tangent), times)[1]


compiled_march = CachedProgram(march_lines)
"""`march_lines` as a compiled program that later processes reuse."""


Step = Callable[[LineMarchState, Any, Any], tuple[LineMarchState, Any]]
"""A step h from a state, with the tangent if the rule reuses one."""


def _step_of(system: LineSystem, stepping: Stepping, tolerance: jax.Array | float) -> Step:
    match rule := stepping.rule:
        case RungeKutta4():
            rates = partial(system_rates, system)
            return lambda now, kept, h: (
                now._replace(states=runge_kutta_step(rates, now.time, now.states, h)),
                kept,
            )
        case ResidualRungeKutta4():
            return lambda now, kept, h: (_residual_step(system, rule, now, h), kept)
        case GeneralizedAlpha():
            return partial(_implicit, system, rule, tolerance, stepping.max_iterations)


def runge_kutta_step(rates: Callable[[Any, Any], Any], time: Any, state: Any, h: Any) -> Any:
    """The state after a step h of the classical Runge-Kutta rule, to fourth order, from y' = rates(t, y)."""

    def moved(by: Any, factor: float) -> Any:
        return jax.tree.map(lambda y, k: y + factor * h * k, state, by)

    k1 = rates(time, state)
    k2 = rates(time + h / 2, moved(k1, 0.5))
    k3 = rates(time + h / 2, moved(k2, 0.5))
    k4 = rates(time + h, moved(k3, 1.0))
    return jax.tree.map(lambda y, a, b, c, d: y + h / 6 * (a + 2 * (b + c) + d), state, k1, k2, k3, k4)


def _kept(system: LineSystem, rule: ResidualRungeKutta4) -> tuple[int, ...]:
    return tuple(min(rule.n_kept, model.velocities.shape[1]) for model in system.lines)


def _residual_step(
    system: LineSystem, rule: ResidualRungeKutta4, now: LineMarchState, h: Any
) -> LineMarchState:
    kept = _kept(system, rule)
    inverse = inverse_of_high(system, kept, now.time, now.states)

    def rates(time: Any, states: States) -> States:
        following, _ = slaved(system, kept, time, states, rule.sweeps, inverse)
        return at_rest_rates(kept, system, system_rates(system, time, following))

    moved = runge_kutta_step(rates, now.time, now.states, h)
    states, contraction = slaved(system, kept, now.time + h, moved, rule.sweeps, inverse)
    return now._replace(states=states, worst=jnp.maximum(now.worst, contraction))


def _implicit(
    system: LineSystem,
    rule: GeneralizedAlpha,
    tolerance: Any,
    most: int,
    now: LineMarchState,
    tangent: Tangent,
    h: Any,
) -> tuple[LineMarchState, Tangent]:
    flat, unravel = ravel_pytree(now.states)

    def rates(time: Any, y: jax.Array) -> jax.Array:
        return ravel_pytree(system_rates(system, time, unravel(y)))[0]

    def slope(time: Any, y: jax.Array) -> jax.Array:
        return system_slope(system, time, unravel(y))

    coefficients = first_order_coefficients(rule.rho_inf)
    done = implicit_step(
        rates, slope, coefficients, now.time, flat, now.rates, h, tangent, tolerance=tolerance, most=most
    )
    reached = LineMarchState(
        now.time,
        unravel(done.state),
        done.rates,
        jnp.maximum(now.worst, done.residual),
        now.iterations + done.iterations,
    )
    return reached, done.tangent
