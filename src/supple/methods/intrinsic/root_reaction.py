"""Force and moment on the root of a line, from the balance of all its stations."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from supple.methods.intrinsic.line_equations import (
    RootTwist,
    decay_rates,
    momenta,
    station_velocities,
    turning_forces,
)
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.line_system import LineSystem, States, places_of, system_rates, system_wrenches
from supple.methods.intrinsic.strain_integration import StationPlaces
from supple.programs.program_cache import CachedProgram

__all__ = ["reactions", "root_reaction"]


def _reactions(system: LineSystem, times: jax.Array, states: States) -> tuple[jax.Array, list[jax.Array]]:

    def at(time: Any, now: States) -> tuple[jax.Array, list[jax.Array]]:
        roots = tuple(None if drive is None else drive.twist(time) for drive in system.drives)
        wrenches = system_wrenches(system, now, time, roots)
        rates = system_rates(system, time, now)
        places = (
            places_of(model, drive, state, time)
            for model, drive, state in zip(system.lines, system.drives, now, strict=True)
        )
        each = zip(system.lines, now, rates, wrenches, roots, places, strict=True)
        return jnp.stack([root_reaction(*line) for line in each]), [rate.q1 for rate in rates]

    return jax.vmap(at)(times, states)


reactions = CachedProgram(_reactions)
"""Forces and moments (t, b, 6) on the roots of b lines, as `root_reaction`, and q_1' (t, m) of each."""


def root_reaction(
    model: LineModel,
    state: LineState,
    rates: LineState,
    wrenches: jax.Array | None,
    root: RootTwist | None,
    places: StationPlaces,
) -> jax.Array:
    """Force and moment (6,) on the body at its root, without loads that act there, along the root's axes.

    The rate of momentum minus the loads, summed over all stations at their positions:

        F = sum R_i h_i,     M = sum R_i m_i + (r_i - r_0) x R_i h_i,     [h; m] = M x_1' + L_1(x_1) M x_1 - f
    """
    x1 = station_velocities(model, state.q1, root)
    # Damping with alpha is an external load on the stations.
    rate = rates.q1 + decay_rates(model, state.q1)
    faster = None if root is None else RootTwist(root.rate, root.rate)
    accelerations = station_velocities(model, rate, faster)
    local = momenta(model, accelerations, rate, faster) + turning_forces(model, x1, state.q1, root)
    if wrenches is not None:
        local = local - wrenches
    force = (places.rotations @ local[:, :3, None])[..., 0]
    moment = (places.rotations @ local[:, 3:, None])[..., 0]
    moment = moment + jnp.cross(places.positions - places.positions[0], force)
    return jnp.concatenate(
        [force.sum(axis=0) @ places.rotations[0], moment.sum(axis=0) @ places.rotations[0]]
    )
