"""A body in a floating frame that joints and forces see at stations: any form of body, beside the others.

Its velocities u are those of its frame and the rates of its r coordinates, as of a reduced body; how its mass
and its strains enter is its own affair. To joints and forces each station is a rigid body without mass, whose
velocities are J(q) u, and whose forces f come back as J^T f:

    M(q) u' + c(q, u) + f(q) - Q + J^T f_s = 0
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from supple.equations.configuration import AnyArray
from supple.integrate import FloatingMotion, FramedMotion, Motion
from supple.machine import System

__all__ = ["BodyState", "SeenMachine", "StationBody", "StationBodyForces", "Stations"]


class BodyState(NamedTuple):
    """Motion of one body at an instant; velocity and acceleration (6 + r,)."""

    time: AnyArray
    origin: AnyArray
    rotation: AnyArray
    coordinates: AnyArray
    velocity: AnyArray
    acceleration: AnyArray


class Stations(NamedTuple):
    """The s stations of a body that joints and forces take hold of.

    positions : (s, 3)
    rotations : (s, 3, 3)
    motion : J (6 s, 6 + r)     their velocities, global, and angular velocities in own axes, by u
    bias : (6 s,)               their rates at constant u
    """

    positions: np.ndarray
    rotations: np.ndarray
    motion: np.ndarray
    bias: np.ndarray


class StationBodyForces(NamedTuple):
    """The terms in balance, (6 + r,) each: force (global), moment (body axes), deformation."""

    inertia: np.ndarray
    internal: np.ndarray
    applied: np.ndarray


class StationBody(Protocol):
    """One such body, with the loads on it that are no force elements."""

    @property
    def index(self) -> int:
        """Its number in the system."""
        ...

    @property
    def n_stations(self) -> int:
        """Number of stations that are seen."""
        ...

    def stations(self, state: BodyState) -> Stations:
        """Where they are and how they move."""
        ...

    def forces(self, state: BodyState) -> StationBodyForces:
        """Its own equations."""
        ...

    def tangent(self, state: BodyState, station_forces: np.ndarray) -> tuple[np.ndarray, ...]:
        """Derivatives M, C, K (6 + r, 6 + r) by u', u and increments, under forces (6 s,) at the stations."""
        ...

    def motion(self, states: list[BodyState]) -> FramedMotion:
        """Its motion over some instants."""
        ...

    def station_motions(self, motion: Motion) -> Mapping[str, FloatingMotion]:
        """Poses of its stations over time, by the names that they have as bodies."""
        ...


@dataclass(frozen=True, eq=False)
class SeenMachine:
    """A machine with such bodies.

    system : System     itself
    seen : System       as joints and forces see it: the other bodies in their order, then all stations
    bodies : of stations, in the order in which they are seen
    """

    system: System
    seen: System
    bodies: tuple[StationBody, ...]
