"""Equilibrium of lines at any deflection: Newton's method on the amplitudes of the internal forces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ConvergenceError, ModelError
from supple.intrinsic.line_equations import line_rates
from supple.intrinsic.line_system import LineSystem, States, system_wrenches

__all__ = ["LineEquilibrium", "line_equilibrium"]

TOLERANCE = 1e-10
"""Of the loads' generalised forces."""
MOST_ITERATIONS = 25
MOST_HALVINGS = 12


class LineEquilibrium(NamedTuple):
    """Where lines rest: their states, the load steps that were taken, and Newton's iterations."""

    states: States
    steps: int
    iterations: int


def line_equilibrium(
    system: LineSystem, states: States, *, time: float = 0.0, n_steps: int = 1
) -> LineEquilibrium:
    """Rest under the loads at a time, reached in steps of their size; a step that fails is halved.

        0 = w q_2 - Phi_1^T [L_2(x_2) C x_2 - s f],     s from 0 to 1

    Parameters
    ----------
    states : where the lines begin, which chooses among several equilibria; root poses are those of the result

    Raises
    ------
    ModelError          a line whose root is free, and rests nowhere of its own
    ConvergenceError    no equilibrium: the share of the loads that was reached
    """
    if any(model.n_rigid for model in system.lines):
        raise ModelError(
            "a line whose root is free to move has no equilibrium of its own: clamp its root, or simulate "
            "with damping until it rests"
        )
    start = tuple(replace(state, q1=jnp.zeros_like(state.q1)) for state in states)
    reached, step = 0.0, 1.0 / n_steps
    taken = iterations = halvings = 0
    while reached < 1 - 1e-12:
        share = min(1.0, reached + step)
        found, residual, count = _search(system, start, time, share)
        iterations += int(count)
        if float(residual) <= TOLERANCE:
            start, reached, taken = found, share, taken + 1
            continue
        halvings += 1
        step /= 2
        if halvings > MOST_HALVINGS:
            raise ConvergenceError(
                f"no equilibrium of the lines beyond {reached:.4g} of the loads: the residual stays at "
                f"{float(residual):.1e} of them. The lines may snap through or buckle there: simulate with "
                "damping, or give smaller loads"
            )
    return LineEquilibrium(start, taken, iterations)


@jax.jit
def _search(system: LineSystem, states: States, time: Any, share: Any) -> tuple[States, jax.Array, jax.Array]:
    sizes = np.cumsum([state.q2.shape[0] for state in states])[:-1]

    def with_forces(flat: jax.Array) -> States:
        parts = jnp.split(flat, sizes)
        return tuple(replace(state, q2=part) for state, part in zip(states, parts, strict=True))

    def forces(flat: jax.Array, factor: Any) -> jax.Array:
        now = with_forces(flat)
        loads = system_wrenches(system, now, time, (None,) * len(now))
        scaled = [None if load is None else factor * load for load in loads]
        return jnp.concatenate(
            [
                line_rates(replace(model, retardation=0.0 * model.retardation), state.q1, state.q2, load)[0]
                for model, state, load in zip(system.lines, now, scaled, strict=True)
            ]
        )

    def size_of(flat: jax.Array) -> jax.Array:
        return jnp.linalg.norm(forces(flat, share) - forces(flat, 0.0)) + 1e-300

    def goes_on(carry: Any) -> jax.Array:
        flat, left, count = carry
        size = jnp.linalg.norm(left)
        return (count < MOST_ITERATIONS) & (size > TOLERANCE * size_of(flat)) & jnp.isfinite(size)

    def improve(carry: Any) -> Any:
        flat, left, count = carry
        tangent = jax.jacfwd(forces)(flat, share)
        flat = flat - jnp.linalg.solve(tangent, left)
        return flat, forces(flat, share), count + 1

    flat = jnp.concatenate([state.q2 for state in states])
    flat, left, count = jax.lax.while_loop(goes_on, improve, (flat, forces(flat, share), 0))
    residual = jnp.linalg.norm(left) / size_of(flat)
    return with_forces(flat), jnp.where(jnp.isfinite(residual), residual, jnp.inf), count
