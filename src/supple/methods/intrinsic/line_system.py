"""Equations of motion of lines with loads and prescribed roots, their derivatives, and forces on roots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jax.scipy.linalg import block_diag

from supple.algebra.rotation import rotation_exp
from supple.arrays import AnyArray
from supple.machine import TimeLaw
from supple.methods.intrinsic.equal_lines import for_each_line
from supple.methods.intrinsic.line_equations import (
    RootTwist,
    decay_rates,
    force_rates,
    l1,
    l2,
    line_forces,
    line_rates,
    momenta,
    on_ends,
    section_strains,
    station_velocities,
    turning_forces,
    viscous_forces,
)
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.station_loads import MovingStations, StationLoad
from supple.methods.intrinsic.strain_integration import StationPlaces, rotation_of, station_places
from supple.programs.program_cache import CachedProgram

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

    screw: AnyArray
    law: TimeLaw
    rotation: AnyArray
    position: AnyArray

    def pose(self, time: AnyArray) -> tuple[jax.Array, jax.Array]:
        """Rotation (3, 3) and position (3,) of the root."""
        value = jnp.asarray(self.law(time), dtype=float)
        turned = self.rotation @ rotation_exp(value * self.screw[3:])
        return turned, self.position + value * (self.rotation @ self.screw[:3])

    def twist(self, time: AnyArray) -> RootTwist:
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


def places_of(model: LineModel, drive: RootDrive | None, state: LineState, time: AnyArray) -> StationPlaces:
    """Rotations and positions of the stations of one line, whose root may be driven."""
    if drive is None:
        return station_places(model, state.q2, rotation_of(state.quaternion), state.position)
    return station_places(model, state.q2, *drive.pose(time))


def system_wrenches(
    system: LineSystem, states: States, time: AnyArray, roots: tuple[RootTwist | None, ...]
) -> list[jax.Array | None]:
    """Forces and moments on the stations of each line, along their own axes; None for an unloaded line."""
    if not system.loads:
        return [None] * len(system.drives)
    need_places = any(load.needs_places for load in system.loads)

    def moving(
        model: LineModel, drive: RootDrive | None, state: LineState, root: RootTwist | None
    ) -> MovingStations:
        places = places_of(model, drive, state, time) if need_places else None
        return MovingStations(places, station_velocities(model, state.q1, root))

    motions = for_each_line(moving, system.lines, system.drives, states, roots)
    return wrenches_on(system.loads, motions, time)


def wrenches_on(
    loads: Sequence[StationLoad], motions: Sequence[MovingStations], time: AnyArray
) -> list[jax.Array | None]:
    """Forces and moments of loads on the stations of each line, for given motions of the stations."""
    sums: list[jax.Array | None] = [None] * len(motions)
    for load in loads:
        for line, wrench in load.wrenches(motions, time):
            own = sums[line]
            sums[line] = wrench if own is None else own + wrench
    return sums


def system_rates(system: LineSystem, time: AnyArray, states: States) -> States:
    """Rates of all states."""
    roots = tuple(None if drive is None else drive.twist(time) for drive in system.drives)
    wrenches = system_wrenches(system, states, time, roots)
    return for_each_line(_rates, system.lines, states, wrenches, roots)


def _rates(model: LineModel, state: LineState, wrench: jax.Array | None, root: RootTwist | None) -> LineState:
    d1, d2 = line_rates(model, state.q1, state.q2, wrench, root)
    return LineState(d1, d2, *root_rates(model, state.q1, state.quaternion))


def _line_slope(model: LineModel, q1: jax.Array, q2: jax.Array, root: RootTwist | None = None) -> jax.Array:
    """Derivatives (m + e, m + e) of `line_rates` by q_1 and q_2, without loads.

    The derivative of a product of two fields has two terms; in each, one field is replaced by its modes. The
    functions of the equations evaluate these terms for all modes at once, with the modes along the last axis.
    This takes a few products of two matrices; automatic differentiation takes a product of a matrix and a
    vector for each mode.
    """
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


def _own_slope(model: LineModel, state: LineState, root: RootTwist | None) -> jax.Array:
    """Derivatives of the rates of one line by its states, without loads."""
    amplitudes = _line_slope(model, state.q1, state.q2, root)
    by_q1, by_turn = jax.jacrev(lambda q, z: jnp.concatenate(root_rates(model, q, z)), (0, 1))(
        state.q1, state.quaternion
    )
    below = jnp.concatenate([by_q1, jnp.zeros((7, state.q2.shape[0])), by_turn, jnp.zeros((7, 3))], axis=1)
    return jnp.concatenate([jnp.pad(amplitudes, ((0, 0), (0, 7))), below])


def system_slope(system: LineSystem, time: AnyArray, states: States) -> jax.Array:
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

    def at(time: AnyArray, now: States) -> tuple[jax.Array, list[jax.Array]]:
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
