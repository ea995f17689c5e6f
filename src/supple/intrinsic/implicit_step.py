"""One step of the generalised-alpha rule for first-order equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.scipy.linalg import lu_factor, lu_solve

__all__ = ["ImplicitStep", "first_order_coefficients", "implicit_step"]


ROUNDING = 1e-14
"""Of the terms of a rate, that its cancellation leaves."""


class FirstOrderCoefficients(NamedTuple):
    """Where rates and states are weighed, and how the step advances."""

    alpha_m: Any
    alpha_f: Any
    gamma: Any


def first_order_coefficients(rho_inf: float) -> FirstOrderCoefficients:
    """Those of spectral radius `rho_inf` at infinite frequency: 1 keeps the energy, 0 removes what is fast.

    alpha_m = (3 - rho) / (2 (1 + rho)),  alpha_f = 1 / (1 + rho),  gamma = 1/2 + alpha_m - alpha_f.
    Source: K. E. Jansen, C. H. Whiting, G. M. Hulbert, "A generalized-alpha method for integrating the
    filtered Navier-Stokes equations", Comput. Methods Appl. Mech. Eng. 190 (2000) 305-319.
    """
    alpha_m, alpha_f = 0.5 * (3 - rho_inf) / (1 + rho_inf), 1 / (1 + rho_inf)
    return FirstOrderCoefficients(alpha_m, alpha_f, 0.5 + alpha_m - alpha_f)


class ImplicitStep(NamedTuple):
    """State and rates at the end of a step, and how its iteration went."""

    state: jax.Array
    rates: jax.Array
    iterations: jax.Array
    residual: jax.Array


def implicit_step(
    rates: Callable[[Any, jax.Array], jax.Array],
    coefficients: FirstOrderCoefficients,
    time: Any,
    state: jax.Array,
    before: jax.Array,
    h: Any,
    *,
    tolerance: Any,
    most: int,
) -> ImplicitStep:
    """The state (n,) after a step h: Newton's method with the tangent of the step's start.

        y_1 = y_0 + h ((1 - gamma) y'_0 + gamma y'_1)
        (1 - alpha_m) y'_0 + alpha_m y'_1 = f(t_0 + alpha_f h, (1 - alpha_f) y_0 + alpha_f y_1)

    With rho_inf = 1 this is the implicit midpoint rule, which keeps every quadratic invariant.

    before : (n,)       y'_0
    tolerance : of the residual, over the largest rate
    most : iterations; beyond them the residual tells that none was found
    """
    alpha_m, alpha_f, gamma = coefficients

    def middle(after: jax.Array) -> jax.Array:
        return state + alpha_f * h * ((1 - gamma) * before + gamma * after)

    def missing(after: jax.Array) -> jax.Array:
        return rates(time + alpha_f * h, middle(after)) - (1 - alpha_m) * before - alpha_m * after

    slope = jax.jacfwd(lambda y: rates(time + alpha_f * h, y))(middle(before))
    # What rounding leaves of the rates of a body that hardly moves.
    noise = ROUNDING / tolerance * jnp.linalg.norm(jnp.abs(slope) @ jnp.abs(state))
    factor = lu_factor(alpha_m * jnp.eye(len(state)) - alpha_f * gamma * h * slope)

    def goes_on(carry: Any) -> jax.Array:
        _, left, size, count = carry
        return (count < most) & (jnp.linalg.norm(left) > tolerance * size)

    def improve(carry: Any) -> Any:
        after, left, _, count = carry
        after = after + lu_solve(factor, left)
        size = noise + jnp.linalg.norm(after) + jnp.linalg.norm(before)
        return after, missing(after), size, count + 1

    left = missing(before)
    size = noise + jnp.linalg.norm(before) + jnp.linalg.norm(left)
    first = before, left, size, jnp.zeros((), dtype=int)
    after, left, size, count = jax.lax.while_loop(goes_on, improve, first)
    moved = state + h * ((1 - gamma) * before + gamma * after)
    return ImplicitStep(moved, after, count, jnp.linalg.norm(left) / jnp.maximum(size, 1e-300))
