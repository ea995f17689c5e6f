"""Line with a free root as a body in a floating frame, for machines with full bodies.

The velocities of the body are u = (V, w, g'): the velocity V (global) and angular velocity w (own components)
of its axes, and the rates of its elastic amplitudes g = -q_2 / omega. The amplitudes q_1 follow linearly,

    A(q_2) q_1 = (R^T V, w, g'),        Y = A^-1 diag(R^T, I, I)

R is the rotation of the axes, I a unit matrix, and e the number of elastic amplitudes. The first six rows of
A give the twist of the axes, the next e rows the rates g' = -q_2' / omega (`force_rates`). The residual of
the line's equations, projected on u, balances forces f at its stations, whose velocities are J u:

    Y^T [ q_1' - rates(q_1, q_2) ] + J^T f = 0,        q_1' = Y u' + Y' u

The mass is Y^T Y, because the modes are mass-normalised. The elastic forces are exactly (0, omega^2 g),
because the couplings of the line have no power.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import rotation_exp, skew, unskew
from supple.arrays import AnyArray
from supple.equations.compiler_options import STARTING
from supple.equations.station_body import BodyState, MachineWithStations, StationBodyForces, Stations
from supple.integrate import FloatingMotion, Motion
from supple.machine import Placed, System
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.joined_machine import lines_as_stations
from supple.methods.intrinsic.line_equations import (
    force_rates,
    line_rates,
    section_strains,
    station_velocities,
)
from supple.methods.intrinsic.line_model import LineModel
from supple.methods.intrinsic.line_system import wrenches_on
from supple.methods.intrinsic.machine_of_lines import line_start
from supple.methods.intrinsic.station_loads import MovingStations, StationLoad, machine_loads
from supple.methods.intrinsic.strain_integration import StationPlaces, station_places
from supple.programs.program_cache import CachedProgram

Array = np.ndarray
STATIC = {"static": True}


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class FrameLine:
    """Arrays of a line, its root (3,) in the body's axes, its loads, and its coupled stations."""

    model: LineModel
    root: AnyArray
    loads: tuple[StationLoad, ...]
    coupled: tuple[int, ...] = field(metadata=STATIC)


@dataclass(frozen=True, eq=False)
class LineInFrame:
    """A `StationBody` of a line."""

    index: int
    placed: Placed
    arrays: FrameLine
    names: tuple[str, ...]
    """Names of the bodies that represent its coupled stations"""

    @property
    def n_stations(self) -> int:
        """Number of coupled stations."""
        return len(self.names)

    def stations(self, state: BodyState) -> Stations:
        """Positions and velocities of the stations."""
        return Stations(*map(np.asarray, _stations(self.arrays, state)))

    def forces(self, state: BodyState) -> StationBodyForces:
        """Forces in the body's own equations."""
        return StationBodyForces(*map(np.asarray, _forces(self.arrays, state)))

    def tangent(self, state: BodyState, station_forces: Array) -> tuple[Array, ...]:
        """Derivatives M, C, K by u', u and increments, under forces (6 s,) at the stations."""
        return tuple(map(np.asarray, _tangent(self.arrays, state, station_forces)))

    def motion(self, states: list[BodyState]) -> IntrinsicMotion:
        """Motion over some instants."""
        r = self.placed.body.n_coordinates
        rates = [_amplitudes(self.arrays, state) for state in states]
        first, second = (np.array([each[number] for each in rates]) for number in range(2))
        velocity = np.array([state.velocity for state in states]).reshape(-1, 6 + r)
        acceleration = np.array([state.acceleration for state in states]).reshape(-1, 6 + r)
        return IntrinsicMotion(
            position=np.array([state.origin for state in states]),
            rotation=np.array([state.rotation for state in states]),
            coordinates=np.array([state.coordinates for state in states]),
            velocity=velocity[:, :3],
            angular_velocity=velocity[:, 3:6],
            rates=first,
            acceleration=acceleration[:, :3],
            angular_acceleration=acceleration[:, 3:6],
            accelerations=second,
        )

    def station_motions(self, motion: Motion) -> Mapping[str, FloatingMotion]:
        """Poses of the stations over time; velocities are zero, since joint forces do not depend on them."""
        rotations, positions = body_of(self.placed).places(motion)
        t = len(positions)
        still, none = np.zeros((t, 3)), np.zeros((t, 0))
        return {
            name: FloatingMotion(
                position=positions[:, number],
                rotation=rotations[:, number],
                coordinates=none,
                velocity=still,
                angular_velocity=still,
                coordinate_rates=none,
                acceleration=still,
                angular_acceleration=still,
                coordinate_accelerations=none,
            )
            for name, number in zip(self.names, self.arrays.coupled, strict=True)
        }


def lines_in_frames(system: System) -> MachineWithStations:
    """A machine with its intrinsic bodies in floating frames; without such bodies, the machine itself.

    Raises ModelError for intrinsic bodies with a supported root.
    """
    if not system.bodies_of(IntrinsicBody):
        return MachineWithStations(system, system, ())
    seen, lines, coupled, on_lines = lines_as_stations(system)
    first, bodies = len(seen.bodies) - sum(map(len, coupled)), []
    for placed, stations in zip(lines, coupled, strict=True):
        body = body_of(placed)
        own = [load for load in on_lines.loads if getattr(load, "body", body.name) == body.name]
        alone = System([placed], loads=own, gravity=system.gravity)
        names = tuple(station.body.name for station in seen.bodies[first : first + len(stations)])
        arrays = FrameLine(body.model, body.line.tree.points[0], machine_loads(alone), stations)
        bodies.append(LineInFrame(system.body_index(body.name), placed, arrays, names))
        first += len(stations)
    placed_all = [_with_frame_rates(each) if each in lines else each for each in system.bodies]
    return MachineWithStations(replace(system, bodies=placed_all), seen, tuple(bodies))


def _with_frame_rates(placed: Placed) -> Placed:
    """The body with velocities u by its initial q_1 (`line_start`); unchanged without deformation rates."""
    if not placed.coordinate_rates.any():
        return placed
    body = body_of(placed)
    line = FrameLine(body.model, body.line.tree.points[0], (), ())
    start = line_start(placed, None, 0.0)
    u = np.asarray(_rows_at_start(line, placed.coordinates)) @ np.asarray(start.q1)
    rates = {"velocity": placed.rotation @ u[:3], "angular_velocity": u[3:6], "coordinate_rates": u[6:]}
    return replace(placed, **rates)


def _frame_rows(line: FrameLine, coordinates: jax.Array) -> jax.Array:
    """A (6 + e, 6 + e): twist of the body's axes and rates of the coordinates by q_1."""
    model = line.model
    strains = section_strains(model, -model.omega * coordinates)

    def seen(q1: jax.Array) -> jax.Array:
        x1 = station_velocities(model, q1)
        v, w = x1[0, :3], x1[0, 3:]
        return jnp.concatenate(
            [v + jnp.cross(line.root, w), w, -force_rates(model, x1, q1, strains) / model.omega]
        )

    return jax.jacfwd(seen)(jnp.zeros(model.velocities.shape[1]))


def _velocities(line: FrameLine, rotation: jax.Array, coordinates: jax.Array, u: jax.Array) -> jax.Array:
    """q_1 from velocities u."""
    along_axes = jnp.concatenate([u[:3] @ rotation, u[3:]])
    return jnp.linalg.solve(_frame_rows(line, coordinates), along_axes)


def _pose_rates(state: BodyState, u: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Rates of origin, rotation and coordinates."""
    return u[:3], state.rotation @ skew(u[3:6]), u[6:]


def _pose(state: BodyState) -> tuple[AnyArray, AnyArray, AnyArray]:
    return state.origin, state.rotation, state.coordinates


def _rates(line: FrameLine, state: BodyState) -> tuple[jax.Array, jax.Array]:
    """q_1 and q_1'."""
    _, *turning = _pose_rates(state, state.velocity)
    return jax.jvp(
        lambda *at: _velocities(line, *at),
        (state.rotation, state.coordinates, state.velocity),
        (*turning, state.acceleration),
    )


def _missing(line: FrameLine, state: BodyState) -> tuple[jax.Array, jax.Array]:
    """Residual of the body's equations (6 + e,), and the loads that are not force elements."""
    model, rows = line.model, _frame_rows(line, state.coordinates)
    q1, rates = _rates(line, state)
    q2 = -model.omega * state.coordinates
    root = state.origin + state.rotation @ line.root
    places: StationPlaces = station_places(model, q2, state.rotation, root)
    (wrench,) = wrenches_on(line.loads, [MovingStations(places, station_velocities(model, q1))], state.time)
    first, _ = line_rates(model, q1, q2, wrench)
    pushed = jnp.zeros_like(q1) if wrench is None else -wrench.reshape(-1) @ model.velocities
    left, loads = jnp.linalg.solve(rows.T, jnp.stack([rates - first, pushed], axis=1)).T
    return tuple(jnp.concatenate([state.rotation @ each[:3], each[3:]]) for each in (left, loads))  # ty: ignore[invalid-explicit-return]


def _places_of_coupled(
    line: FrameLine, origin: AnyArray, rotation: AnyArray, coordinates: AnyArray
) -> StationPlaces:
    q2 = -line.model.omega * coordinates
    places = station_places(line.model, q2, rotation, origin + rotation @ line.root)
    coupled = np.array(line.coupled, dtype=int)
    return StationPlaces(places.rotations[coupled], places.positions[coupled])


def _twists(line: FrameLine, state: BodyState, u: jax.Array) -> jax.Array:
    """Velocities, global, and angular velocities, in own axes, of the coupled stations, (6 s,)."""
    places, rates = jax.jvp(lambda *at: _places_of_coupled(line, *at), _pose(state), _pose_rates(state, u))
    spin = jax.vmap(unskew)(jnp.einsum("sji,sjk->sik", places.rotations, rates.rotations))
    return jnp.concatenate([rates.positions, spin], axis=1).reshape(-1)


def _moved(state: BodyState, increment: jax.Array) -> BodyState:
    return state._replace(
        origin=state.origin + increment[:3],
        rotation=state.rotation @ rotation_exp(increment[3:6]),
        coordinates=state.coordinates + increment[6:],
    )


def _stations_at(line: FrameLine, state: BodyState) -> tuple[jax.Array, ...]:
    places = _places_of_coupled(line, *_pose(state))
    u = state.velocity
    motion = jax.jacfwd(lambda v: _twists(line, state, v))(jnp.zeros_like(u))
    _, bias = jax.jvp(lambda s: _twists(line, _moved(state, s * u), u), (jnp.zeros(()),), (jnp.ones(()),))
    return places.positions, places.rotations, motion, bias


def _forces_at(line: FrameLine, state: BodyState) -> tuple[jax.Array, ...]:
    whole, applied = _missing(line, state)
    internal = jnp.concatenate([jnp.zeros(6), line.model.omega**2 * state.coordinates])
    return whole - internal - applied, internal, applied


def _tangent_at(line: FrameLine, state: BodyState, forces: jax.Array) -> tuple[jax.Array, ...]:
    def left(increment: jax.Array, u: jax.Array, faster: jax.Array) -> jax.Array:
        near = _moved(state._replace(velocity=u, acceleration=faster), increment)
        _, back = jax.vjp(lambda v: _twists(line, near, v), jnp.zeros_like(u))
        return _missing(line, near)[0] + back(forces)[0]

    at = jnp.zeros_like(state.velocity), state.velocity, state.acceleration
    stiffness, damping, mass = jax.jacfwd(left, (0, 1, 2))(*at)
    return mass, damping, stiffness


_rows_at_start = CachedProgram(_frame_rows, STARTING)
_stations = CachedProgram(_stations_at, STARTING)
_forces = CachedProgram(_forces_at, STARTING)
_tangent = CachedProgram(_tangent_at, STARTING)
_amplitudes = CachedProgram(_rates, STARTING)
