"""A rigid body on a four-point frame: a modal sub-domain without modes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import jax.numpy as jnp
import numpy as np

from supple.arrays import FloatArray
from supple.body import RigidBody
from supple.methods.explicit.frame_moments import Moments
from supple.methods.explicit.frame_points import CORNERS, FramePoints


@dataclass(frozen=True, eq=False)
class RigidFrame:
    """A rigid body with the interface of a `ModalSubdomain`; mass, centre and inertia are exact."""

    body: RigidBody

    mass_damping: ClassVar[float] = 0.0
    stiffness_damping: ClassVar[float] = 0.0
    spin_stiffness: ClassVar[None] = None
    n_modes: ClassVar[int] = 0

    @property
    def name(self) -> str:
        """Name of the body."""
        return self.body.name

    @property
    def nodes(self) -> FloatArray:
        """(N, 3) positions of its interfaces."""
        return self.body.nodes

    @property
    def frequencies(self) -> FloatArray:
        """Empty: there are no modes."""
        return np.zeros(0)

    @property
    def shapes(self) -> FloatArray:
        """(N, 3, 0), without modes."""
        return np.zeros((len(self.nodes), 3, 0))

    @cached_property
    def points(self) -> FramePoints:
        """Points at the centre of mass, with arms of the radius of gyration."""
        own = self.body
        return FramePoints(own.centre, float(np.sqrt(np.trace(own.inertia) / (2 * own.mass))))

    @property
    def moments(self) -> Moments:
        """S0 = m e_O e_O^T + E J E^T / arm^2, J = tr(I) / 2 - I: the second moments of the mass."""
        inertia = self.body.inertia
        second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
        S0 = CORNERS @ second @ CORNERS.T / self.points.arm**2
        S0[0, 0] += self.body.mass
        return Moments(jnp.asarray(S0), jnp.zeros((4, 3, 0)), jnp.zeros((3, 3, 0, 0)))
