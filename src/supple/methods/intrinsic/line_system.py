"""Equations of motion of a machine of lines with loads and prescribed roots, and the forces on its roots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from supple.algebra.rotation import rotation_exp
from supple.methods.intrinsic.equal_lines import for_each_line
from supple.methods.intrinsic.line_equations import (
    RootTwist,
    decay_rates,
    line_rates,
    momenta,
    station_velocities,
    turning_forces,
)
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.station_loads import MovingStations, StationLoad
from supple.methods.intrinsic.strain_integration import StationPlaces, rotation_of, station_places
from supple.programs.program_cache import CachedProgram

__all__ = [
    "LineSystem",
    "RootDrive",
    "States",
    "places_of",
    "reactions",
    "root_rates",
    "system_rates",
    "system_wrenches",
    "wrenches_on",
]

States = tuple[LineState, ...]
"""States, one for each line."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class RootDrive:
    """Motion of the root by screw * law(time) from its pose where the law is zero.

    screw : (6,)        a unit translation, then a unit rotation, along the root's axes; one of them zero
    law : TimeLaw       distance or angle; automatic differentiation gives its two derivatives
    rotation, position : (3, 3), (3,)   pose of the root where the law is zero
    """

    screw: Any
    law: Any
    rotation: Any
    position: Any

    def pose(self, time: Any) -> tuple[jax.Array, jax.Array]:
        """Rotation (3, 3) and position (3,) of the root."""
        value = jnp.asarray(self.law(time), dtype=float)
        turned = self.rotation @ rotation_exp(value * self.screw[3:])
        return turned, self.position + value * (self.rotation @ self.screw[:3])

    def twist(self, time: Any) -> RootTwist:
        """The root's velocities, and their rates, along its own axes."""
        time = jnp.asarray(time, dtype=float)
        one = jnp.ones_like(time)

        def value(t: jax.Array) -> jax.Array:
            return jnp.asarray(self.law(t), dtype=float)

        def rate(t: jax.Array) -> jax.Array:
            return jax.jvp(value, (t,), (one,))[1]

        first, second = jax.jvp(rate, (time,), (one,))
        return RootTwist(first * self.screw, second * self.screw)


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class LineSystem:
    """Lines, prescribed motions of their roots, and loads; the first two with one entry per line."""

    lines: Sequence[LineModel]
    drives: tuple[RootDrive | None, ...]
    loads: tuple[StationLoad, ...]


def places_of(model: LineModel, drive: RootDrive | None, state: LineState, time: Any) -> StationPlaces:
    """Rotations and positions of the stations of one line, whose root may be driven."""
    if drive is None:
        return station_places(model, state.q2, rotation_of(state.quaternion), state.position)
    return station_places(model, state.q2, *drive.pose(time))


def system_wrenches(
    system: LineSystem, states: States, time: Any, roots: tuple[RootTwist | None, ...]
) -> list[jax.Array | None]:
    """Forces and moments on the stations of each line, along their own axes; None for an unloaded line."""
    if not system.loads:
        return [None] * len(system.drives)
    need_places = any(load.needs_places for load in system.loads)

    def moving(model: LineModel, drive: Any, state: LineState, root: RootTwist | None) -> MovingStations:
        places = places_of(model, drive, state, time) if need_places else None
        return MovingStations(places, station_velocities(model, state.q1, root))

    motions = for_each_line(moving, system.lines, system.drives, states, roots)
    return wrenches_on(system.loads, motions, time)


def wrenches_on(
    loads: Sequence[StationLoad], motions: Sequence[MovingStations], time: Any
) -> list[jax.Array | None]:
    """Forces and moments of loads on the stations of each line, for given motions of the stations."""
    sums: list[jax.Array | None] = [None] * len(motions)
    for load in loads:
        for line, wrench in load.wrenches(motions, time):
            own = sums[line]
            sums[line] = wrench if own is None else own + wrench
    return sums


def system_rates(system: LineSystem, time: Any, states: States) -> States:
    """Rates of all states."""
    roots = tuple(None if drive is None else drive.twist(time) for drive in system.drives)
    wrenches = system_wrenches(system, states, time, roots)
    return for_each_line(_rates, system.lines, states, wrenches, roots)


def _rates(model: LineModel, state: LineState, wrench: jax.Array | None, root: RootTwist | None) -> LineState:
    d1, d2 = line_rates(model, state.q1, state.q2, wrench, root)
    return LineState(d1, d2, *root_rates(model, state.q1, state.quaternion))


def root_rates(model: LineModel, q1: jax.Array, quaternion: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Rates of the root's quaternion and position: zero for a root without rigid modes.

    Source: [Wang2015] (4), (5).
    """
    k = model.n_rigid
    if k == 0:
        return jnp.zeros(4), jnp.zeros(3)
    twist = model.velocities[:6] @ q1
    v, w = twist[:3], twist[3:]
    s, z = quaternion[0], quaternion[1:]
    turn = 0.5 * jnp.concatenate([-(w @ z)[None], s * w + jnp.cross(z, w)])
    return turn, rotation_of(quaternion) @ v


def _reactions(system: LineSystem, times: jax.Array, states: States) -> tuple[jax.Array, list[jax.Array]]:
    """Forces and moments (t, b, 6) on the roots of b lines, and q_1' (t, m) of each."""

    def at(time: Any, now: States) -> tuple[jax.Array, list[jax.Array]]:
        roots = tuple(None if drive is None else drive.twist(time) for drive in system.drives)
        wrenches = system_wrenches(system, now, time, roots)
        rates = system_rates(system, time, now)
        places = (
            places_of(model, drive, state, time)
            for model, drive, state in zip(system.lines, system.drives, now, strict=True)
        )
        each = zip(system.lines, now, rates, wrenches, roots, places, strict=True)
        return jnp.stack([_root_reaction(*line) for line in each]), [rate.q1 for rate in rates]

    return jax.vmap(at)(times, states)


def _root_reaction(
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


reactions = CachedProgram(_reactions)
