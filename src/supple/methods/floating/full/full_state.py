"""States of machines with full bodies, and the residuals of their equations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from supple.equations.balance import Balance
from supple.equations.configuration import Configuration, ControlStep, SystemMotion
from supple.equations.station_body import BodyState, Stations


class Unknowns(NamedTuple):
    """Unknowns of a step, or changes of them."""

    acceleration: np.ndarray
    multipliers: np.ndarray
    frame_multipliers: tuple[np.ndarray, ...]


class FullState(NamedTuple):
    """State of the system; velocities and accelerations contain frame (6,) and coordinates of every body."""

    time: float
    configuration: Configuration
    velocity: np.ndarray
    acceleration: np.ndarray
    auxiliary: np.ndarray
    multipliers: np.ndarray
    frame_multipliers: tuple[np.ndarray, ...]
    control: ControlStep | None = None
    """Controllers in the step that ends here (length 0 after `FullSystem.ended`); None without controllers"""

    @property
    def unknowns(self) -> Unknowns:
        """The unknowns of the step that ends here."""
        return Unknowns(self.acceleration, self.multipliers, self.frame_multipliers)


class InteriorState(NamedTuple):
    """Motion of one full body: its frame, angular quantities in body components, and its coordinates."""

    rotation: np.ndarray
    coordinates: np.ndarray
    rates: np.ndarray
    accelerations: np.ndarray
    angular_velocity: np.ndarray
    angular_acceleration: np.ndarray
    acceleration: np.ndarray
    """Global acceleration of the frame origin minus gravity."""
    frame_multipliers: np.ndarray
    time: float


Targets = tuple[np.ndarray, tuple[np.ndarray, ...]]
"""Targets of the constraint rows, and of the frame conditions of each full body"""


class LineEvaluation(NamedTuple):
    """A body with stations, at one iterate."""

    state: BodyState
    stations: Stations
    residual: np.ndarray
    """(6 + r,), with the forces at its stations"""
    station_forces: np.ndarray
    """(6 s,)"""


class Evaluation(NamedTuple):
    """Residuals at one iterate."""

    border_motion: SystemMotion
    border: Balance
    constraint_residual: np.ndarray
    interior_states: tuple[InteriorState, ...]
    interior_residuals: tuple[np.ndarray, ...]
    """(6 + n,) for each full body; the last n include its interface forces"""
    frame_residuals: tuple[np.ndarray, ...]
    relative_residual: np.ndarray
    largest_terms: np.ndarray
    """Reference norms for the residuals of force, moment and deformation, (3,)"""
    rotations: np.ndarray
    """Rotations of the system's bodies, (nb, 3, 3)"""
    lines: tuple[LineEvaluation, ...] = ()

    def closing(self, by_position: float) -> Targets:
        """Accelerations of constraint rows and frame conditions that cancel their residuals."""
        frames = tuple(-residual / by_position for residual in self.frame_residuals)
        return -self.constraint_residual / by_position, frames

    def left_with(self, border: np.ndarray, interiors: tuple[np.ndarray, ...]) -> Evaluation:
        """The evaluation with other residuals: (n,) of the border, and (6 + n,) of each full body."""
        none = np.zeros_like(self.border.inertia)
        return self._replace(
            border=self.border._replace(inertia=none, internal=none, applied=border, joint=none),
            constraint_residual=np.zeros_like(self.constraint_residual),
            interior_residuals=interiors,
            frame_residuals=tuple(np.zeros_like(each) for each in self.frame_residuals),
            lines=tuple(line._replace(residual=np.zeros_like(line.residual)) for line in self.lines),
        )
