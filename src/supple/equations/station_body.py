"""A body in a floating frame, of any form, with joints and forces at stations.

Its velocities u are those of its frame and the rates of its r coordinates, as for a reduced body. For
joints and forces, each station is a rigid body without mass. Its velocities are J(q) u, and forces f_s on it
act on the body as J^T f_s:

    M(q) u' + c(q, u) + f(q) - Q + J^T f_s = 0
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from supple.arrays import AnyArray
from supple.integrate import FloatingMotion, FramedMotion, Motion
from supple.machine import System


class BodyState(NamedTuple):
    """Motion of one body at an instant; velocity and acceleration (6 + r,)."""

    time: AnyArray
    origin: AnyArray
    rotation: AnyArray
    coordinates: AnyArray
    velocity: AnyArray
    acceleration: AnyArray


class Stations(NamedTuple):
    """The s stations of a body, at which joints and forces act.

    positions : (s, 3)
    rotations : (s, 3, 3)
    motion : J (6 s, 6 + r)     map of u to their velocities (global) and angular velocities (station axes)
    bias : (6 s,)               rates of these velocities at constant u
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
    """A body with stations, and the loads on it that are not force elements."""

    @property
    def index(self) -> int:
        """Number of the body in the system."""

    @property
    def n_stations(self) -> int:
        """Number of stations in use."""

    def stations(self, state: BodyState) -> Stations:
        """Positions and motion of the stations."""

    def forces(self, state: BodyState) -> StationBodyForces:
        """The forces in the equations of the body."""

    def tangent(self, state: BodyState, station_forces: np.ndarray) -> tuple[np.ndarray, ...]:
        """Derivatives M, C, K (6 + r, 6 + r) of the body's equations by u', u and increments.

        station_forces : (6 s,)     f_s
        """

    def motion(self, states: list[BodyState]) -> FramedMotion:
        """Motion of the body over some times."""

    def station_motions(self, motion: Motion) -> Mapping[str, FloatingMotion]:
        """Motions of its stations over time, by their names as bodies."""


@dataclass(frozen=True, eq=False)
class MachineWithStations:
    """A machine with station bodies.

    system : System     the machine
    seen : System       the machine for joints and forces: the other bodies in their order, then all stations
    bodies : the station bodies, in the order of their stations
    """

    system: System
    seen: System
    bodies: tuple[StationBody, ...]
