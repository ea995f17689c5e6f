"""A flexible body simulated with all its finite-element freedoms, as the reference for reduced ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, vstack

from supple.body import FlexibleBody, Frame, RayleighDamping
from supple.body.interface import BodyInterface

__all__ = ["FullBody"]


@dataclass(frozen=True, eq=False)
class FullBody:
    """All coordinates of a flexible body in a floating frame, held to the frame by six multipliers.

    body : FlexibleBody    nonlinear where it has quadratic strains; `body.linearized()` otherwise
    frame : NodalFixedFrame | MeanAxisFrame
    damping : RayleighDamping | None
    """

    body: FlexibleBody
    frame: Frame
    damping: RayleighDamping | None = None

    @property
    def name(self) -> str:
        """Name of the body."""
        return self.body.name

    @property
    def r(self) -> int:
        """Number of coordinates: all of them."""
        return self.body.n

    @property
    def nodes(self) -> np.ndarray:
        """(N, 3) rest positions."""
        return self.body.nodes

    @property
    def interfaces(self) -> tuple[BodyInterface, ...]:
        """The body's interfaces."""
        return self.body.interfaces

    @property
    def interface_motions(self) -> csr_array:
        """Displacement and rotation of all interfaces per coordinate, (6 p, n)."""
        motions = [interface.motion for interface in self.interfaces]
        return csr_array(vstack(motions)) if motions else csr_array((0, self.r))

    def expand(self, coordinates: np.ndarray) -> np.ndarray:
        """Nodal displacements (..., N, 3) of coordinates (..., n), in the body's frame."""
        nodal = np.asarray(coordinates) @ self.body.expansion.T
        shape = (*nodal.shape[:-1], len(self.nodes), self.body.dofs_per_node)
        return nodal.reshape(shape)[..., :3]
