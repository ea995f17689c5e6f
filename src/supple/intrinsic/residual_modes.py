"""Residual modes: high modes that follow the others at rest, so that their frequencies bind no step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp

from supple.intrinsic.line_model import LineModel, LineState
from supple.intrinsic.line_system import LineSystem, States, system_rates

__all__ = ["at_rest_rates", "slaved"]


def slaved(
    system: LineSystem, kept: tuple[int, ...], time: Any, states: States, sweeps: int
) -> tuple[States, jax.Array]:
    """The states with their high modes where the rates of these vanish, and the contraction of the search.

        q_2H = -n_1H(q) / w_H,     q_1H = n_2H(q) / w_H

    where n is what besides w acts on a high mode: couplings and loads. Each sweep puts the last values in.

    kept : modes of each line, rigid ones included, that stay dynamic
    Returns the states, and the change of the last sweep over that of the one before; 0 where none moves.
    Source: [Wang2015] (37).
    """
    changes = []
    for _ in range(sweeps):
        rates = system_rates(system, time, states)
        moved = tuple(
            _follow(model, state, rate, n)
            for model, state, rate, n in zip(system.lines, states, rates, kept, strict=True)
        )
        changes.append(jnp.sqrt(sum(_square(a, b) for a, b in zip(moved, states, strict=True))))
        states = moved
    size = jnp.sqrt(sum(state.q1 @ state.q1 + state.q2 @ state.q2 for state in states))
    floor = 1e-9 * size + 1e-300
    ratio = changes[-1] / jnp.maximum(changes[-2], floor)
    return states, jnp.where(changes[-1] > floor, ratio, 0.0)


def at_rest_rates(kept: tuple[int, ...], system: LineSystem, rates: States) -> States:
    """Rates with those of the high modes zero."""
    return tuple(
        replace(
            rate,
            q1=jnp.where(jnp.arange(rate.q1.shape[0]) < n, rate.q1, 0.0),
            q2=jnp.where(jnp.arange(rate.q2.shape[0]) < n - model.n_rigid, rate.q2, 0.0),
        )
        for model, rate, n in zip(system.lines, rates, kept, strict=True)
    )


def _follow(model: LineModel, state: LineState, rate: LineState, kept: int) -> LineState:
    first = kept - model.n_rigid
    w = model.omega[first:]
    q1, q2 = state.q1[kept:], state.q2[first:]
    # The high mode rests, so that its viscous force is none of its own.
    n1 = rate.q1[kept:] - w * (q2 + model.retardation[first:] * rate.q2[first:])
    n2 = rate.q2[first:] + w * q1
    return replace(state, q1=state.q1.at[kept:].set(n2 / w), q2=state.q2.at[first:].set(-n1 / w))


def _square(a: LineState, b: LineState) -> jax.Array:
    return jnp.sum((a.q1 - b.q1) ** 2) + jnp.sum((a.q2 - b.q2) ** 2)
