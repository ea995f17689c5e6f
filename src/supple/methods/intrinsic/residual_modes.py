"""Residual modes: high modes that follow the low modes statically, so that they do not limit the step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from supple.methods.intrinsic.line_slope import system_slope
from supple.methods.intrinsic.line_system import LineSystem, States, system_rates

__all__ = ["at_rest_rates", "inverse_of_high", "slaved"]


def inverse_of_high(system: LineSystem, kept: tuple[int, ...], time: Any, states: States) -> jax.Array:
    """Inverse (N, N) of the derivative of the high modes' rates by their own amplitudes."""
    high = _high(system, kept)
    return jnp.linalg.inv(system_slope(_resting(system, kept), time, states)[np.ix_(high, high)])


def slaved(
    system: LineSystem,
    kept: tuple[int, ...],
    time: Any,
    states: States,
    sweeps: int,
    inverse: jax.Array | None = None,
) -> tuple[States, jax.Array]:
    """States whose high modes have zero rates, and the contraction of the iteration.

        0 = w_H q_2H + n_1H(q),     0 = -w_H q_1H + n_2H(q)

    with n the couplings and loads on a high mode. Newton's method with one tangent solves these equations.
    The fixed-point iteration of [Wang2015] evaluates n at the last values. It diverges for strongly coupled
    modes, such as those that carry the axial force of a bent body.

    kept : number of dynamic modes of each line, with the rigid ones
    inverse : result of `inverse_of_high` at a nearby state; by default computed here
    Returns the states, and the ratio of the changes in the last two sweeps; 0 if the last is negligible.
    Source: [Wang2015] (37).
    """
    high = _high(system, kept)
    resting = _resting(system, kept)
    flat, unravel = ravel_pytree(states)
    if inverse is None:
        inverse = inverse_of_high(system, kept, time, states)
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


def at_rest_rates(kept: tuple[int, ...], system: LineSystem, rates: States) -> States:
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
