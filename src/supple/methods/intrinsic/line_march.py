"""Time integration of lines through output times by one compiled program.

Residual modes are high modes that follow the low modes statically, so that they do not limit explicit steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jax.tree_util import register_static

from supple.arrays import AnyArray
from supple.integrate import GeneralizedAlpha, ResidualRungeKutta4, RungeKutta4
from supple.methods.intrinsic.implicit_step import (
    Tangent,
    first_order_coefficients,
    first_tangent,
    implicit_step,
)
from supple.methods.intrinsic.line_system import LineSystem, States, system_rates, system_slope
from supple.programs.program_cache import CachedProgram

S = TypeVar("S")

LineRule = RungeKutta4 | ResidualRungeKutta4 | GeneralizedAlpha
"""Step rules for lines; GeneralizedAlpha(1.0) conserves energy."""


class LineMarchState(NamedTuple):
    """State of a time integration of lines.

    rates : (N,)        rates of all states in one vector, for the implicit rule; empty for other rules
    worst : ()          largest contraction of residual modes, or residual of a step, since the start
    iterations : ()     iterations of implicit steps since the start
    """

    time: AnyArray
    states: States
    rates: AnyArray
    worst: AnyArray
    iterations: AnyArray


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


_Carry = tuple[LineMarchState, Tangent | None]
"""State, and the tangent if the rule reuses one."""
_Step = Callable[[LineMarchState, Any, AnyArray], _Carry]
"""A step h from a state."""


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

    def to_output(carry: _Carry, end: jax.Array) -> tuple[_Carry, LineMarchState]:
        begin = carry[0].time
        h = (end - begin) / n_steps

        def one(now: _Carry, number: jax.Array) -> tuple[_Carry, None]:
            return step(now[0]._replace(time=begin + number * h), now[1], h), None

        (last, known), _ = jax.lax.scan(one, carry, jnp.arange(n_steps))
        last = last._replace(time=end)
        return (last, known), last

    return jax.lax.scan(to_output, (start, tangent), times)[1]


compiled_march = CachedProgram(march_lines)
"""`march_lines` as a compiled program that later processes reuse."""


def _step_of(system: LineSystem, stepping: Stepping, tolerance: jax.Array | float) -> _Step:
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


def full_leg(history: S, length: int) -> S:
    """A history (t, ...), or a tree of histories, padded to `length` instants by copies of the last one.

    A program would be compiled again for legs of another length.
    """

    def filled(leaf: np.ndarray) -> np.ndarray:
        known = np.asarray(leaf)
        more = max(length - len(known), 0)
        return np.pad(known, ((0, more), *((0, 0),) * (known.ndim - 1)), mode="edge")

    return jax.tree.map(filled, history)


def n_good(history: object, converged: np.ndarray) -> int:
    """Number of instants (t,) of a tree of histories before the first not finite, or not converged."""
    sizes = [np.abs(leaf).reshape(len(leaf), -1).sum(axis=1) for leaf in jax.tree.leaves(history)]
    return int(np.argmin(np.append(np.isfinite(np.sum(sizes, axis=0)) & converged, False)))


def runge_kutta_step(rates: Callable[[AnyArray, S], S], time: AnyArray, state: S, h: AnyArray) -> S:
    """The state after a step h of the classical Runge-Kutta rule, to fourth order, from y' = rates(t, y)."""

    def moved(by: S, factor: float) -> S:
        return jax.tree.map(lambda y, k: y + factor * h * k, state, by)

    k1 = rates(time, state)
    k2 = rates(time + h / 2, moved(k1, 0.5))
    k3 = rates(time + h / 2, moved(k2, 0.5))
    k4 = rates(time + h, moved(k3, 1.0))
    return jax.tree.map(lambda y, a, b, c, d: y + h / 6 * (a + 2 * (b + c) + d), state, k1, k2, k3, k4)


def _kept(system: LineSystem, rule: ResidualRungeKutta4) -> tuple[int, ...]:
    return tuple(min(rule.n_kept, model.velocities.shape[1]) for model in system.lines)


def _residual_step(
    system: LineSystem, rule: ResidualRungeKutta4, now: LineMarchState, h: AnyArray
) -> LineMarchState:
    kept = _kept(system, rule)
    inverse = _inverse_of_high(system, kept, now.time, now.states)

    def rates(time: AnyArray, states: States) -> States:
        following, _ = slaved(system, kept, time, states, rule.sweeps, inverse)
        return _at_rest_rates(kept, system, system_rates(system, time, following))

    moved = runge_kutta_step(rates, now.time, now.states, h)
    states, contraction = slaved(system, kept, now.time + h, moved, rule.sweeps, inverse)
    return now._replace(states=states, worst=jnp.maximum(now.worst, contraction))


def _implicit(
    system: LineSystem,
    rule: GeneralizedAlpha,
    tolerance: AnyArray,
    most: int,
    now: LineMarchState,
    tangent: Tangent,
    h: AnyArray,
) -> tuple[LineMarchState, Tangent]:
    flat, unravel = ravel_pytree(now.states)

    def rates(time: AnyArray, y: jax.Array) -> jax.Array:
        return ravel_pytree(system_rates(system, time, unravel(y)))[0]

    def slope(time: AnyArray, y: jax.Array) -> jax.Array:
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


def _inverse_of_high(system: LineSystem, kept: tuple[int, ...], time: AnyArray, states: States) -> jax.Array:
    """Inverse (N, N) of the derivative of the high modes' rates by their own amplitudes."""
    high = _high(system, kept)
    return jnp.linalg.inv(system_slope(_resting(system, kept), time, states)[np.ix_(high, high)])


def slaved(
    system: LineSystem,
    kept: tuple[int, ...],
    time: AnyArray,
    states: States,
    sweeps: int,
    inverse: jax.Array | None = None,
) -> tuple[States, jax.Array]:
    """States whose high modes follow the low ones statically, and the contraction of the iteration.

        0 = w_H q_2H + n_1H(q),     0 = -w_H q_1H + n_2H(q)

    with n the couplings and loads on a high mode. Newton's method with one tangent solves these equations.
    The fixed-point iteration of [Wang2015] evaluates n at the last values. It diverges for strongly coupled
    modes, such as those that carry the axial force of a bent body.

    kept : number of dynamic modes of each line, with the rigid ones
    inverse : result of `_inverse_of_high` at a nearby state; by default computed here
    Returns the states, and the ratio of the changes in the last two sweeps; 0 if the last is negligible.
    Source: [Wang2015] (37).
    """
    high = _high(system, kept)
    resting = _resting(system, kept)
    flat, unravel = ravel_pytree(states)
    if inverse is None:
        inverse = _inverse_of_high(system, kept, time, states)
    changes = []
    for _ in range(sweeps):
        change = inverse @ ravel_pytree(system_rates(resting, time, unravel(flat)))[0][high]
        flat = flat.at[high].add(-change)
        changes.append(jnp.linalg.norm(change))
    moved = unravel(flat)
    size = jnp.sqrt(sum(state.q1 @ state.q1 + state.q2 @ state.q2 for state in moved))
    floor = 1e-9 * size + 1e-300
    ratio = changes[-1] / jnp.maximum(changes[-2], floor)
    return moved, jnp.where(changes[-1] > floor, ratio, 0.0)


def _at_rest_rates(kept: tuple[int, ...], system: LineSystem, rates: States) -> States:
    """The rates, with zero for the high modes."""
    return tuple(
        replace(
            rate,
            q1=jnp.where(jnp.arange(rate.q1.shape[0]) < n, rate.q1, 0.0),
            q2=jnp.where(jnp.arange(rate.q2.shape[0]) < n - model.n_rigid, rate.q2, 0.0),
        )
        for model, rate, n in zip(system.lines, rates, kept, strict=True)
    )


def _resting(system: LineSystem, kept: tuple[int, ...]) -> LineSystem:
    """The system without viscous forces of the high modes, whose rates are zero."""
    lines = tuple(
        replace(
            model,
            retardation=jnp.where(
                jnp.arange(model.omega.shape[0]) < n - model.n_rigid, model.retardation, 0.0
            ),
        )
        for model, n in zip(system.lines, kept, strict=True)
    )
    return replace(system, lines=lines)


def _high(system: LineSystem, kept: tuple[int, ...]) -> np.ndarray:
    """Numbers of the high modes' amplitudes among all states."""
    found, first = [], 0
    for model, n in zip(system.lines, kept, strict=True):
        m, e = model.velocities.shape[1], model.omega.shape[0]
        found += [np.arange(n, m) + first, np.arange(n - model.n_rigid, e) + m + first]
        first += m + e + 7
    return np.concatenate(found)
