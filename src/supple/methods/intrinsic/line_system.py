"""Equations of motion of a machine of lines, with loads and prescribed roots, as one function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from supple.methods.intrinsic.equal_lines import for_each_line
from supple.methods.intrinsic.line_equations import RootTwist, line_rates, station_velocities
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.root_drive import RootDrive
from supple.methods.intrinsic.station_loads import MovingStations, StationLoad
from supple.methods.intrinsic.strain_integration import StationPlaces, rotation_of, station_places

__all__ = [
    "LineSystem",
    "States",
    "places_of",
    "root_rates",
    "system_rates",
    "system_wrenches",
    "wrenches_on",
]

States = tuple[LineState, ...]
"""States, one for each line."""


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
