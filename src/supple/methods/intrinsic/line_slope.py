"""Derivatives of a machine's quadratic equations by its states, from products of its modes.

The derivative of a product of two fields has two terms; in each, one field is replaced by its modes. The
functions of the equations evaluate these terms for all modes at once, with the modes along the last axis.
This takes a few products of two matrices; automatic differentiation takes a product of a matrix and a vector
for each mode.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jax.scipy.linalg import block_diag

from supple.methods.intrinsic.equal_lines import for_each_line
from supple.methods.intrinsic.line_equations import (
    RootTwist,
    decay_rates,
    force_rates,
    l1,
    l2,
    line_forces,
    momenta,
    on_ends,
    section_strains,
    station_velocities,
    viscous_forces,
)
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.line_system import LineSystem, States, root_rates, system_wrenches

__all__ = ["line_slope", "system_slope"]


def line_slope(model: LineModel, q1: jax.Array, q2: jax.Array, root: RootTwist | None = None) -> jax.Array:
    """Derivatives (m + e, m + e) of `line_rates` by q_1 and q_2, without loads."""
    m, e = q1.shape[0], q2.shape[0]
    x1, strains = station_velocities(model, q1, root), section_strains(model, q2)
    Phi = model.velocities.reshape(-1, 6, m)
    C = model.strains.reshape(-1, 6, e)
    by_q1 = force_rates(model, Phi, jnp.eye(m), strains[..., None])
    by_q2 = force_rates(model, x1[..., None], jnp.zeros((m, e)), C)
    stress = q2 + viscous_forces(model, force_rates(model, x1, q1, strains))
    stress_by_q1 = viscous_forces(model, by_q1)
    stress_by_q2 = jnp.eye(e) + viscous_forces(model, by_q2)

    p = momenta(model, x1, q1, root)
    turning = l1(Phi, p[..., None]) + l1(x1[..., None], momenta(model, Phi, jnp.eye(m), None))
    half = 0.5 * model.lengths[:, None, None]
    first = on_ends(model, turning, half * l2(line_forces(model, stress_by_q1), strains[..., None]))
    bent = l2(line_forces(model, stress_by_q2), strains[..., None])
    bent = bent + l2(line_forces(model, stress)[..., None], C)
    second = on_ends(model, jnp.zeros((*x1.shape, e)), half * bent)
    inertial = jnp.concatenate([first, second], axis=2).reshape(-1, m + e)
    top = -(model.velocities.T @ inertial)
    top = top.at[:, :m].add(-decay_rates(model, jnp.eye(m)))
    elastic = model.omega[:, None] * jnp.concatenate([stress_by_q1, stress_by_q2], axis=1)
    top = top.at[model.n_rigid :].add(elastic)
    return jnp.concatenate([top, jnp.concatenate([by_q1, by_q2], axis=1)])


def system_slope(system: LineSystem, time: Any, states: States) -> jax.Array:
    """Derivatives (N, N) of `system_rates` by all states, both as vectors by `ravel_pytree`."""
    roots = tuple(None if drive is None else drive.twist(time) for drive in system.drives)
    slope = block_diag(*for_each_line(_own_slope, system.lines, states, roots))
    if not any(load.needs_places for load in system.loads):
        return slope
    flat, unravel = ravel_pytree(states)

    def wrenches(y: jax.Array) -> list[jax.Array | None]:
        return system_wrenches(system, unravel(y), time, roots)

    row = 0
    for model, state, pushed in zip(system.lines, states, jax.jacfwd(wrenches)(flat), strict=True):
        m = state.q1.shape[0]
        if pushed is not None:
            slope = slope.at[row : row + m].add(model.velocities.T @ pushed.reshape(-1, flat.size))
        row += m + state.q2.shape[0] + 7
    return slope


def _own_slope(model: LineModel, state: LineState, root: RootTwist | None) -> jax.Array:
    """Derivatives of the rates of one line by its states, without loads."""
    amplitudes = line_slope(model, state.q1, state.q2, root)
    by_q1, by_turn = jax.jacrev(lambda q, z: jnp.concatenate(root_rates(model, q, z)), (0, 1))(
        state.q1, state.quaternion
    )
    below = jnp.concatenate([by_q1, jnp.zeros((7, state.q2.shape[0])), by_turn, jnp.zeros((7, 3))], axis=1)
    return jnp.concatenate([jnp.pad(amplitudes, ((0, 0), (0, 7))), below])
