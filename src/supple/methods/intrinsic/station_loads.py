"""Loads on the stations of lines, as functions of the stations' positions and velocities and of time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp

from supple.machine.pose import Pose
from supple.methods.intrinsic.strain_integration import StationPlaces

__all__ = ["End", "Follower", "Gravity", "MovingStations", "SpreadLoad", "StationElement", "StationLoad"]

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
    @abstractmethod
    def needs_places(self) -> bool:
        """Whether the load depends on the positions of stations."""

    @abstractmethod
    def wrenches(self, motions: Sequence[MovingStations], time: Any) -> Iterator[tuple[int, jax.Array]]:
        """Number of a line and forces and moments (n, 6) on its stations, along their own axes."""


def _one(motion: MovingStations, station: jax.Array, wrench: jax.Array) -> jax.Array:
    # `where` instead of a scatter, which would be a loop over the cases of a batch.
    return jnp.where(jnp.arange(motion.velocities.shape[0])[:, None] == station, wrench, 0.0)


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Follower:
    """A force and moment that rotate with a station: axes (6, 3) @ law(time), along its own axes."""

    axes: Any
    law: Any
    station: Any
    line: int = field(metadata=STATIC)
    needs_places: bool = field(default=False, metadata=STATIC)

    def wrenches(self, motions: Sequence[MovingStations], time: Any) -> Iterator[tuple[int, jax.Array]]:
        """Forces and moments on one station."""
        yield self.line, _one(motions[self.line], self.station, self.axes @ jnp.asarray(self.law(time)))


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Gravity:
    """Weight of every station, and its inertia force due to base acceleration, including eccentric masses.

    mass : (n, 6, 3)    momenta of each station at unit velocities; (6 n, 3 n) if stations share mass
    """

    mass: Any
    gravity: Any
    base: Any
    """Law of the base's acceleration, or None"""
    line: int = field(metadata=STATIC)
    needs_places: bool = field(default=True, metadata=STATIC)

    def wrenches(self, motions: Sequence[MovingStations], time: Any) -> Iterator[tuple[int, jax.Array]]:
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

    axes: Any
    point: Any
    station: Any
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
    law: Any
    parameters: Any
    function: Callable[..., Any] = field(metadata=STATIC)
    needs_places: bool = field(default=True, metadata=STATIC)

    def wrenches(self, motions: Sequence[MovingStations], time: Any) -> Iterator[tuple[int, jax.Array]]:
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

    law: Any
    stations: Any
    weights: Any
    arms: Any
    facets: Any
    line: int = field(metadata=STATIC)
    facet_forces: Callable[..., Any] = field(metadata=STATIC)
    value_rank: int = field(metadata=STATIC)
    needs_places: bool = field(default=True, metadata=STATIC)

    def wrenches(self, motions: Sequence[MovingStations], time: Any) -> Iterator[tuple[int, jax.Array]]:
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
