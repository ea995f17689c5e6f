"""Loads on the stations of lines, as functions of the stations' positions and velocities and of time.

`machine_loads` makes them of the loads of a machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.build_model import check_apart, initial_points
from supple.errors import ModelError
from supple.machine import (
    GROUND,
    At,
    BaseAcceleration,
    DeadForce,
    FollowerForce,
    FollowerTorque,
    ForceElement,
    NodalLoad,
    Placed,
    System,
    TimeLaw,
)
from supple.machine.pose import Pose, Wrench
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.methods.intrinsic.strain_integration import StationPlaces
from supple.value_content import fixed_function

STATIC = {"static": True}


class MovingStations(NamedTuple):
    """Positions of a line's stations, and their velocities and angular velocities (n, 6) along own axes.

    places : StationPlaces | None      None if no load depends on positions
    """

    places: StationPlaces | None
    velocities: jax.Array


class StationLoad(Protocol):
    """A load of a machine of lines."""

    @property
    def needs_places(self) -> bool:
        """Whether the load depends on the positions of stations."""

    def wrenches(self, motions: Sequence[MovingStations], time: AnyArray) -> Iterator[tuple[int, jax.Array]]:
        """Number of a line and forces and moments (n, 6) on its stations, along their own axes."""


def _one(motion: MovingStations, station: jax.Array, wrench: jax.Array) -> jax.Array:
    # `where` instead of a scatter, which would be a loop over the cases of a batch.
    return jnp.where(jnp.arange(motion.velocities.shape[0])[:, None] == station, wrench, 0.0)


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Follower:
    """A force and moment that rotate with a station: axes (6, 3) @ law(time), along its own axes."""

    axes: AnyArray
    law: TimeLaw
    station: AnyArray
    line: int = field(metadata=STATIC)
    needs_places: bool = field(default=False, metadata=STATIC)

    def wrenches(self, motions: Sequence[MovingStations], time: AnyArray) -> Iterator[tuple[int, jax.Array]]:
        """Forces and moments on one station."""
        yield self.line, _one(motions[self.line], self.station, self.axes @ jnp.asarray(self.law(time)))


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Gravity:
    """Weight of every station, and its inertia force due to base acceleration, including eccentric masses.

    mass : (n, 6, 3)    momenta of each station at unit velocities; (6 n, 3 n) if stations share mass
    """

    mass: AnyArray
    gravity: AnyArray
    base: TimeLaw | None
    """Law of the base's acceleration, or None"""
    line: int = field(metadata=STATIC)
    needs_places: bool = field(default=True, metadata=STATIC)

    def wrenches(self, motions: Sequence[MovingStations], time: AnyArray) -> Iterator[tuple[int, jax.Array]]:
        """M [R^T g; 0] on every station."""
        places = motions[self.line].places
        assert places is not None
        g = self.gravity if self.base is None else self.gravity - jnp.asarray(self.base(time))
        local = (places.rotations * g[:, None]).sum(axis=1)
        if self.mass.ndim == 2:
            yield self.line, (self.mass @ local.reshape(-1)).reshape(-1, 6)
        else:
            yield self.line, (self.mass * local[:, None, :]).sum(axis=2)


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class End:
    """An end of a force element: a station of a line, or a point of the ground (line -1).

    axes : (3, 3)   axes of the element, in station axes; on the ground, in global axes
    point : (3,)    position of the ground point
    """

    axes: AnyArray
    point: AnyArray
    station: AnyArray
    line: int = field(metadata=STATIC)

    def pose(self, motions: Sequence[MovingStations]) -> Pose:
        """Global position, axes, velocity and angular velocity."""
        if self.line < 0:
            return Pose(self.point, self.axes, jnp.zeros(3), jnp.zeros(3))
        motion = motions[self.line]
        assert motion.places is not None
        rotation = motion.places.rotations[self.station]
        x1 = motion.velocities[self.station]
        return Pose(
            motion.places.positions[self.station], rotation @ self.axes, rotation @ x1[:3], rotation @ x1[3:]
        )


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class StationElement:
    """Any force element of a machine between two ends; `function` is `wrenches` of its class."""

    ends: tuple[End, End]
    law: TimeLaw | None
    parameters: tuple[AnyArray, ...]
    function: Callable[..., tuple[Wrench, Wrench]] = field(metadata=STATIC)
    needs_places: bool = field(default=True, metadata=STATIC)

    def wrenches(self, motions: Sequence[MovingStations], time: AnyArray) -> Iterator[tuple[int, jax.Array]]:
        """Forces and moments on the stations of both ends."""
        value = None if self.law is None else self.law(time)
        poses = [end.pose(motions) for end in self.ends]
        for end, wrench in zip(self.ends, self.function(*poses, value, self.parameters), strict=True):
            if end.line >= 0:
                places = motions[end.line].places
                assert places is not None
                rotation = places.rotations[end.station]
                local = jnp.concatenate([wrench.force @ rotation, wrench.moment @ rotation])
                yield end.line, _one(motions[end.line], end.station, local)


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class SpreadLoad:
    """A nodal load of a machine on points attached to stations.

    stations : (k, 2)   the two stations that a point follows rigidly
    weights : (k, 2)    weights of the two stations
    arms : (k, 2, 3)    vectors from station to point at rest
    facets : (f, p)     points of every facet
    """

    law: TimeLaw
    stations: AnyArray
    weights: AnyArray
    arms: AnyArray
    facets: AnyArray
    line: int = field(metadata=STATIC)
    facet_forces: Callable[..., jax.Array] = field(metadata=STATIC)
    value_rank: int = field(metadata=STATIC)
    needs_places: bool = field(default=True, metadata=STATIC)

    def wrenches(self, motions: Sequence[MovingStations], time: AnyArray) -> Iterator[tuple[int, jax.Array]]:
        """Forces and moments on the stations with the same virtual work as the forces on the points."""
        motion = motions[self.line]
        assert motion.places is not None
        rotations = motion.places.rotations[self.stations]
        arms = (rotations * self.arms[:, :, None, :]).sum(-1)
        points = (self.weights[..., None] * (motion.places.positions[self.stations] + arms)).sum(axis=1)
        value = jnp.asarray(self.law(time))
        by_facet = 0 if value.ndim > self.value_rank else None
        on_facets = jax.vmap(lambda x, v: self.facet_forces(x, jnp.eye(3), v), in_axes=(0, by_facet))(
            points[self.facets], value
        )
        forces = jnp.zeros(points.shape).at[self.facets].add(on_facets)
        local = (rotations * forces[:, None, :, None]).sum(axis=2) * self.weights[..., None]
        wrench = jnp.concatenate([local, jnp.cross(self.arms, local)], axis=2)
        yield self.line, jnp.zeros(motion.velocities.shape).at[self.stations].add(wrench)


def machine_loads(system: System) -> tuple[StationLoad, ...]:
    """The loads, and gravity, of a machine of intrinsic bodies.

    Raises ModelError for two base accelerations, and for a force along a line whose ends coincide.
    """
    numbers = {placed.body.name: number for number, placed in enumerate(system.bodies)}
    bases = [load.law for load in system.loads if isinstance(load, BaseAcceleration)]
    if len(bases) > 1:
        raise ModelError(f"only one base acceleration is supported; {len(bases)} are given: add them up")
    found: list[StationLoad] = []
    if system.gravity.any() or bases:
        base = bases[0] if bases else None
        found += [
            Gravity(_translating_mass(body_of(placed)), system.gravity, base, number)
            for number, placed in enumerate(system.bodies)
        ]
    for load in system.loads:
        match load:
            case BaseAcceleration():
                pass
            case NodalLoad():
                found.append(_spread(system.bodies, numbers[load.body], load))
            case FollowerForce() | FollowerTorque() if GROUND == load.second:
                found.append(_follower(system.bodies, numbers, load))
            case ForceElement():
                found.append(_element(system, numbers, load))
    return tuple(found)


def _translating_mass(body: IntrinsicBody) -> np.ndarray:
    """Momenta of stations in unit translations: (n, 6, 3), or (6 n, 3 n) where stations share mass."""
    masses = body.line.station_masses
    if masses is not None:
        return masses[:, :, :3]
    n = body.line.n
    return body.line.mass.reshape(6 * n, n, 6)[:, :, :3].reshape(6 * n, 3 * n)


def _follower(
    bodies: Sequence[Placed], numbers: Mapping[str, int], load: FollowerForce | FollowerTorque
) -> Follower:
    line = numbers[load.first.body]
    placed = bodies[line]
    axes = np.zeros((6, 3))
    rows = slice(0, 3) if isinstance(load, FollowerForce) else slice(3, 6)
    axes[rows] = placed.assembly.rotation.T @ load.initial_axes
    law = load.law
    assert law is not None
    return Follower(axes, law, body_of(placed).interface(load.first.interface).number, line)


def _element(system: System, numbers: Mapping[str, int], load: ForceElement) -> StationElement:
    check_apart(system, load)
    points = initial_points(system, load)
    element = load.assembled(*points)

    def end(own: At, point: np.ndarray) -> End:
        if own == GROUND:
            return End(element.initial_axes, point, 0, -1)
        line = numbers[own.body]
        placed = system.bodies[line]
        station = body_of(placed).interface(own.interface).number
        return End(placed.assembly.rotation.T @ element.initial_axes, np.zeros(3), station, line)

    ends = end(element.first, points[0]), end(element.second, points[1])
    return StationElement(ends, element.law, element.parameters, fixed_function(type(element).wrenches))


def _spread(bodies: Sequence[Placed], line: int, load: NodalLoad) -> SpreadLoad:
    body = body_of(bodies[line])
    if load.nodes.size:
        stations, weights = body.expansion.stations[load.nodes], body.expansion.weights[load.nodes]
        arms = body.expansion.arms(body.line.tree)[load.nodes]
    else:
        assert isinstance(load, DeadForce)
        number = body.interface(str(load.at)).number
        stations, weights, arms = np.array([[number] * 2]), np.array([[1.0, 0.0]]), np.zeros((1, 2, 3))
    return SpreadLoad(
        law=load.law,
        stations=stations,
        weights=weights,
        arms=arms,
        facets=load.facets.astype(np.int32),
        line=line,
        facet_forces=type(load).facet_forces,
        value_rank=len(load.value_shapes[0]),
    )
