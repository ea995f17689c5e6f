"""Motions of the two kinds of sub-domain, one row per output time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from supple.integrate.motion import StackedMotion, register_motion

__all__ = ["FourPointMotion", "NodalMotion"]


@register_motion
@dataclass(frozen=True)
class NodalMotion(StackedMotion):
    """Motion of the nodes of an explicit sub-domain."""

    kind: ClassVar[str] = "nodal"

    nodes: np.ndarray
    """(t, N, 3) positions in space."""
    velocities: np.ndarray
    """(t, N, 3) over the step before; at the start, those of that instant."""
    plastic_strain: np.ndarray
    """(t, E) equivalent plastic strain of each element, the largest of its points; zero of elastic ones."""
    alive: np.ndarray
    """(t, E) 1, or 0 from when an element has been deleted."""
    von_mises: np.ndarray
    """(t, E) von Mises' Cauchy stress of each element, the largest of its points; zero of deleted ones."""


@register_motion
@dataclass(frozen=True)
class FourPointMotion(StackedMotion):
    """Motion of the four points and the modes of a modal sub-domain."""

    kind: ClassVar[str] = "four-point"

    points: np.ndarray
    """(t, 4, 3) O, A, B, C in space."""
    coordinates: np.ndarray
    """(t, k) of the modes of the sub-domain."""
    point_rates: np.ndarray
    """(t, 4, 3) over the step before."""
    coordinate_rates: np.ndarray
    """(t, k)."""

    @property
    def angular_velocity(self) -> np.ndarray:
        """(t, 3) of the frame in its own axes, rad/s, over the step before."""
        P, rates = (points[:, 1:] - points[:, :1] for points in (self.points, self.point_rates))
        W = P @ rates.swapaxes(1, 2) / (P**2).sum(axis=2).mean(axis=1)[:, None, None]
        return 0.5 * np.stack([W[:, i, j] - W[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1)
