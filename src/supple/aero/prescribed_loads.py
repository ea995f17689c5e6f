"""Prescribed loads: air loads per length, lumped on nodes of a blade over time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from supple.aero.blade_element_momentum import Operation, air_loads
from supple.aero.rotor import Rotor
from supple.aero.wind import Wind
from supple.algebra.read_only import read_only
from supple.arrays import FloatArray
from supple.errors import ModelError

__all__ = ["CosineRamp", "NodalForces", "lumped_forces", "prescribed_forces"]


@dataclass(frozen=True)
class CosineRamp:
    """A smooth start: (1 - cos(pi t / duration)) / 2, and 1 from `duration` (s) on."""

    duration: float

    def __post_init__(self) -> None:
        if not (isfinite(self.duration) and self.duration > 0):
            raise ModelError(f"ramp of {self.duration} s; give a finite duration above zero")

    def at(self, times: ArrayLike) -> FloatArray:
        """Factor (t,) at the times (t,)."""
        part = np.clip(np.asarray(times, dtype=np.float64) / self.duration, 0, 1)
        return (1 - np.cos(np.pi * part)) / 2


@dataclass(frozen=True, eq=False)
class NodalForces:
    """Forces (t, k, 3), N, on k nodes at times (t,), s, in the axes of the blade's root."""

    times: FloatArray
    forces: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "times", read_only(self.times))
        object.__setattr__(self, "forces", read_only(self.forces))

    def turned(self, azimuth: ArrayLike) -> NodalForces:
        """Forces on a blade rotated about x by the azimuth (t,), rad, in fixed axes."""
        cos, sin = np.cos(azimuth)[:, None], np.sin(azimuth)[:, None]
        x, y, z = np.moveaxis(self.forces, -1, 0)
        return replace(self, forces=np.stack([x, cos * y - sin * z, sin * y + cos * z], axis=-1))


def lumped_forces(span: ArrayLike, normal: ArrayLike, tangential: ArrayLike) -> FloatArray:
    """Forces (..., k, 3) on nodes at the spans (k,): F_N along +x, F_T along -y, each times a share of span.

    The share of a node reaches half the way to each neighbour, so that the shares add up to the length.

    span : (k,)    m, increasing, k >= 2
    normal, tangential : (..., k)   N/m at the nodes
    Raises ModelError for a span that does not increase.
    """
    span = np.asarray(span, dtype=np.float64)
    if span.ndim != 1 or span.size < 2 or (np.diff(span) <= 0).any():
        raise ModelError("give nodes from root to tip, at least two, each at a different span")
    share = np.diff(span, prepend=span[0], append=span[-1])
    share = (share[:-1] + share[1:]) / 2
    normal, tangential = np.asarray(normal) * share, np.asarray(tangential) * share
    return np.stack([normal, -tangential, np.zeros_like(normal)], axis=-1)


def prescribed_forces(
    rotor: Rotor,
    operation: Operation,
    wind: Wind,
    *,
    span: ArrayLike,
    hub_radius: float,
    times: ArrayLike,
    ramp: CosineRamp | None = None,
) -> NodalForces:
    """Forces on nodes of a blade over time; the rotor speed is constant, and the blade is upright at t = 0.

    The aerodynamic loads are those of a rigid blade, and thus prescribed. Axes: x downwind, y towards
    the trailing edge, z along the span from the root, at radius = span + hub_radius.

    Parameters
    ----------
    span : float array (k,)     m, of the nodes from root to tip, such as those of the leading edge
    hub_radius : float          m
    times : float array (t,)    s
    ramp : CosineRamp or None   a smooth start; None: full loads from the first time
    Returns
    -------
    NodalForces   (t, k, 3)
    Raises
    ------
    ModelError, ConvergenceError   as for `air_loads`
    """
    times, radius = np.asarray(times, dtype=np.float64), np.asarray(span, dtype=np.float64) + hub_radius
    azimuth = operation.angular_speed * times
    loads = air_loads(
        rotor, operation, radius=radius, wind=wind.along_blade(times, radius=radius, azimuth=azimuth)
    )
    forces = lumped_forces(span, loads.normal, loads.tangential)
    start = np.ones_like(times) if ramp is None else ramp.at(times)
    return NodalForces(times, start[:, None, None] * forces)
