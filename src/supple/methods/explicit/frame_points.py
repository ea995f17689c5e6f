"""Four points O, A, B, C that define the frame of a modal sub-domain, and the weights of material points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ModelError

CORNERS = np.vstack([-np.ones((1, 3)), np.eye(3)])
"""(4, 3): a point at local X has weights (1 - X - Y - Z, X, Y, Z) = e_O + CORNERS X."""
LINKS = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
"""The six pairs of points with a fixed distance."""


@dataclass(frozen=True, eq=False)
class FramePoints:
    """Four points that span an orthogonal frame of equal arms.

        x = sum_a w_a(X) x_a,     w = (1 - X - Y - Z, X, Y, Z),     X = (x - origin) / arm

    origin : (3,)       position of O in the undeformed body, m
    arm : float         length of OA, OB and OC, m: about a radius of gyration, for a well-conditioned
                        4 x 4 mass matrix of the points
    """

    origin: FloatArray
    arm: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.arm) and self.arm > 0):
            raise ModelError(f"the arm of a four-point frame must be a positive length, got {self.arm}")

    def weights(self, points: FloatArray) -> FloatArray:
        """Weights w (n, 4) of material points (n, 3)."""
        local = (points - self.origin) / self.arm
        return np.array([1.0, 0, 0, 0]) + local @ CORNERS.T

    def placed(self, position: FloatArray, rotation: FloatArray) -> FloatArray:
        """Points (4, 3) in space for the body's axes at `position` with rotation `rotation`."""
        own = self.origin + self.arm * np.vstack([np.zeros((1, 3)), np.eye(3)])
        return position + own @ rotation.T

    @property
    def rigid_rates(self) -> FloatArray:
        """(4, 3, 6): rates of the points per unit velocity and angular velocity, in the axes of the body."""
        rates = np.zeros((4, 3, 6))
        rates[:, :, :3] = np.eye(3)
        for i, axis in enumerate(np.eye(3)):
            rates[:, :, 3 + i] = np.cross(axis, self.placed(np.zeros(3), np.eye(3)) - self.origin)
        return rates

    @property
    def squared_lengths(self) -> FloatArray:
        """Squared lengths (6,) of the links, m^2: three arms, three diagonals."""
        return self.arm**2 * np.array([1.0, 1, 1, 2, 2, 2])
