"""Force and moment on the root of a line, from the balance of all that it carries."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from supple.intrinsic.line_equations import RootTwist, on_stations, section_strains, station_velocities
from supple.intrinsic.line_model import LineModel, LineState
from supple.intrinsic.line_system import LineSystem, States, system_rates, system_wrenches

__all__ = ["reactions", "root_reaction"]


@jax.jit
def reactions(system: LineSystem, times: jax.Array, states: States) -> jax.Array:
    """Forces and moments (t, b, 6) on the roots of b lines, as `root_reaction`, at t times."""

    def at(time: Any, now: States) -> jax.Array:
        roots = tuple(None if drive is None else drive.twist(time) for drive in system.drives)
        wrenches = system_wrenches(system, now, time, roots)
        rates = system_rates(system, time, now)
        each = zip(system.lines, now, rates, wrenches, roots, strict=True)
        return jnp.stack([root_reaction(*line) for line in each])

    return jax.vmap(at)(times, states)


def root_reaction(
    model: LineModel,
    state: LineState,
    rates: LineState,
    wrenches: jax.Array | None,
    root: RootTwist | None,
) -> jax.Array:
    """Force and moment (6,) that act on the body at its root besides its loads, along the root's axes.

    The virtual work of the equations of motion in the six rigid motions of the undeformed line, which have no
    linear strain: what is missing for balance is the reaction.
    """
    x1 = station_velocities(model, state.q1, root)
    e = section_strains(model, state.q2)
    stress = state.q2 + model.retardation * rates.q2
    inside = on_stations(model, x1, state.q1, stress, e, root)
    if wrenches is not None:
        inside = inside - wrenches
    momenta = model.twist_momenta.T @ (model.velocities @ (rates.q1 + model.decay * state.q1))
    if root is not None:
        momenta = momenta + model.twist_momenta.T @ (model.twists @ root.rate)
    return jnp.asarray(inside.reshape(-1) @ model.twists + momenta)
