"""The outcome of a simulation: the motion of every body at the output times, and what it cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

__all__ = ["FloatingMotion", "Solution", "Statistics", "concatenate"]


@dataclass(frozen=True)
class FloatingMotion:
    """Motion of one body's floating frame and of its deformation coordinates, one row per output time."""

    position: np.ndarray
    """(t, 3) frame origin, global components."""
    rotation: np.ndarray
    """(t, 3, 3) rotation matrix, body components to global ones."""
    coordinates: np.ndarray
    """(t, r) deformation coordinates: reduced ones, or the nodal ones of a full body."""
    velocity: np.ndarray
    """(t, 3) velocity of the frame origin, global components."""
    angular_velocity: np.ndarray
    """(t, 3) angular velocity of the frame, body components, rad/s."""
    coordinate_rates: np.ndarray
    """(t, r)."""
    acceleration: np.ndarray
    """(t, 3) acceleration of the frame origin, global components."""
    angular_acceleration: np.ndarray
    """(t, 3) rate of the angular velocity, body components."""
    coordinate_accelerations: np.ndarray
    """(t, r)."""

    def at(self, rows: slice | np.ndarray) -> FloatingMotion:
        """The motion at some of its output times, by their numbers."""
        return FloatingMotion(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})


@dataclass(frozen=True)
class Statistics:
    """Cost of a run: accepted steps, Newton iterations, cut steps, wall seconds with and for compilation."""

    steps: int = 0
    iterations: int = 0
    rejected_steps: int = 0
    seconds: float = 0.0
    compile_seconds: float = 0.0

    def __add__(self, other: Statistics) -> Statistics:
        return Statistics(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))


@dataclass(frozen=True)
class Solution:
    """A finished (part of a) simulation."""

    times: np.ndarray
    """(t,) output times."""
    bodies: Mapping[str, FloatingMotion]
    joint_forces: Mapping[str, np.ndarray]
    """Joint name to (t, m) Lagrange multipliers, in the order of the joint's constraint equations: forces and
    moments of the joint on its first end, along the first end's joint axes (z is the joint's axis)."""
    statistics: Statistics

    def at(self, rows: slice | np.ndarray) -> Solution:
        """The solution at some of its output times, by their numbers; its cost remains that of the whole."""
        return Solution(
            times=self.times[rows],
            bodies={name: motion.at(rows) for name, motion in self.bodies.items()},
            joint_forces={name: forces[rows] for name, forces in self.joint_forces.items()},
            statistics=self.statistics,
        )


def concatenate(parts: Sequence[Solution]) -> Solution:
    """One solution from consecutive parts; the parts share bodies and joints and do not repeat a time."""
    if not parts:
        raise ValueError("no parts to join: a solution needs at least one chunk of output times")

    def join(field: str, name: str) -> np.ndarray:
        return np.concatenate([getattr(part.bodies[name], field) for part in parts])

    first = parts[0]
    return Solution(
        times=np.concatenate([part.times for part in parts]),
        bodies={
            name: FloatingMotion(**{f.name: join(f.name, name) for f in fields(FloatingMotion)})
            for name in first.bodies
        },
        joint_forces={
            name: np.concatenate([part.joint_forces[name] for part in parts]) for name in first.joint_forces
        },
        statistics=sum((part.statistics for part in parts), Statistics()),
    )
