"""One step of the generalised-alpha rule for first-order equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.arrays import AnyArray

ROUNDING = 1e-14
"""Rounding error of a rate, relative to its terms."""
SLOW = 0.1
"""Ratio of successive residuals above which the tangent is renewed."""
SAME_STEP = 1e-6
"""Relative change of step up to which a tangent is reused."""


class FirstOrderCoefficients(NamedTuple):
    """Weights of rates and states in the rule."""

    alpha_m: AnyArray
    alpha_f: AnyArray
    gamma: AnyArray


def first_order_coefficients(rho_inf: float) -> FirstOrderCoefficients:
    """Coefficients for spectral radius `rho_inf` at infinite frequency: 1 conserves energy, 0 damps most.

    alpha_m = (3 - rho) / (2 (1 + rho)),  alpha_f = 1 / (1 + rho),  gamma = 1/2 + alpha_m - alpha_f.
    Source: K. E. Jansen, C. H. Whiting, G. M. Hulbert, "A generalized-alpha method for integrating the
    filtered Navier-Stokes equations", Comput. Methods Appl. Mech. Eng. 190 (2000) 305-319.
    """
    alpha_m, alpha_f = 0.5 * (3 - rho_inf) / (1 + rho_inf), 1 / (1 + rho_inf)
    return FirstOrderCoefficients(alpha_m, alpha_f, 0.5 + alpha_m - alpha_f)


class Tangent(NamedTuple):
    """Inverse of a step's tangent, reused over steps while Newton's method converges with it.

    inverse : (n, n)    inverse of alpha_m - alpha_f gamma h slope; multiplying by it is faster than solving
    step : h of this tangent; negative before the first
    rounding : norm of the terms of the rates relative to that of the states, the scale of rounding errors
    """

    inverse: AnyArray
    step: AnyArray
    rounding: AnyArray


_Carry = tuple[jax.Array, jax.Array, jax.Array, jax.Array, jax.Array, jax.Array, Tangent]
"""Rates at the end, residual, relative residual, whether it decreases slowly, whether the tangent is of this
step, number of iterations, tangent."""


class StepResult(NamedTuple):
    """State and rates at the end of a step, last tangent, number of iterations, and relative residual."""

    state: jax.Array
    rates: jax.Array
    tangent: Tangent
    iterations: jax.Array
    residual: jax.Array


def first_tangent(n: int) -> Tangent:
    """Tangent before the first step of n states."""
    return Tangent(jnp.eye(n), jnp.asarray(-1.0), jnp.zeros(()))


def implicit_step(
    rates: Callable[[AnyArray, jax.Array], jax.Array],
    slope: Callable[[AnyArray, jax.Array], jax.Array],
    coefficients: FirstOrderCoefficients,
    time: AnyArray,
    state: jax.Array,
    before: jax.Array,
    h: AnyArray,
    tangent: Tangent,
    *,
    tolerance: AnyArray,
    most: int,
) -> StepResult:
    """The state (n,) after a step h, by Newton's method; a tangent that converges slowly is renewed.

        y_1 = y_0 + h ((1 - gamma) y'_0 + gamma y'_1)
        (1 - alpha_m) y'_0 + alpha_m y'_1 = f(t_0 + alpha_f h, (1 - alpha_f) y_0 + alpha_f y_1)

    With rho_inf = 1 this is the implicit midpoint rule, which conserves every quadratic invariant.
    Derivatives of the result, in forward or reverse mode, are those of the equations that it solves.

    rates, slope : f (n,) and its derivatives (n, n) by the state
    before : (n,)       y'_0
    tangent : tangent of an earlier step
    tolerance : largest residual at the end, relative to the rates at both ends of the step
    most : largest number of iterations; the residual of the result shows whether they converged
    """
    alpha_m, alpha_f, gamma = coefficients

    def middle(after: jax.Array) -> jax.Array:
        return state + alpha_f * h * ((1 - gamma) * before + gamma * after)

    def missing(after: jax.Array) -> jax.Array:
        return rates(time + alpha_f * h, middle(after)) - (1 - alpha_m) * before - alpha_m * after

    def made_anew(after: jax.Array) -> Tangent:
        at = middle(after)
        matrix = slope(time + alpha_f * h, at)
        inverse = jnp.linalg.inv(alpha_m * jnp.eye(len(state)) - alpha_f * gamma * h * matrix)
        size = jnp.linalg.norm(jnp.abs(matrix) @ jnp.abs(at)) / (jnp.linalg.norm(at) + 1e-300)
        return Tangent(inverse, jnp.asarray(h, dtype=float), size)

    def measured(after: jax.Array, left: jax.Array, known: Tangent) -> jax.Array:
        # Rounding error in the rates of a body that hardly moves.
        noise = ROUNDING / tolerance * known.rounding * jnp.linalg.norm(state)
        size = noise + jnp.linalg.norm(after) + jnp.linalg.norm(before)
        return jnp.linalg.norm(left) / jnp.maximum(size, 1e-300)

    def goes_on(carry: _Carry) -> jax.Array:
        _, _, error, _, _, count, _ = carry
        return (count < most) & ~(error <= tolerance)

    def found(_: object, first: jax.Array) -> tuple[jax.Array, tuple[jax.Array, jax.Array, Tangent]]:
        at_first = missing(first)

        def improve(carry: _Carry) -> _Carry:
            after, left, error, slow, is_own, count, known = carry
            # A tangent of another step may have caused divergence.
            again = slow & ~is_own
            after, left = jnp.where(again, first, after), jnp.where(again, at_first, left)
            known = jax.lax.cond(slow, made_anew, lambda _: known, after)
            after = after + known.inverse @ left
            left = missing(after)
            now = measured(after, left, known)
            return after, left, now, ~(now <= SLOW * error), is_own | slow, count + 1, known

        other = jnp.abs(h - tangent.step) > SAME_STEP * jnp.abs(h)
        count = jnp.zeros((), dtype=int)
        error = measured(first, at_first, tangent)
        begin = first, at_first, error, other, jnp.zeros((), dtype=bool), count, tangent
        after, _, error, _, _, count, known = jax.lax.while_loop(goes_on, improve, begin)
        return after, (jnp.asarray(count, dtype=float), error, known)  # whole numbers have no derivatives

    def tangent_solve(linear: Callable[[jax.Array], jax.Array], right: jax.Array) -> jax.Array:
        return jnp.linalg.solve(jax.jacfwd(linear)(right), right)

    after, (count, error, known) = jax.lax.custom_root(missing, before, found, tangent_solve, has_aux=True)
    moved = state + h * ((1 - gamma) * before + gamma * after)
    return StepResult(moved, after, known, jnp.asarray(count, dtype=int), error)
