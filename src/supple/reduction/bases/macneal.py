"""MacNeal's method: free-interface modes joined by the residual flexibility, without its mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from supple.reduction.components.component_model import ReducedMatrices, block_diagonal
from supple.reduction.components.free_interface_component import FreeInterfaceComponent, require_residual

__all__ = ["MacNealComponent"]


@dataclass(frozen=True, eq=False)
class MacNealComponent:
    """Free-interface modes eta and interface motion q_v, joined by springs of the residual flexibility.

        q_v = B Phi eta + F f    gives    f = F^-1 (q_v - B Phi eta)

        K = [ Lambda + (B Phi)^T F^-1 B Phi    -(B Phi)^T F^-1 ]     M = [ I  0 ]
            [ -F^-1 B Phi                       F^-1           ]         [ 0  0 ]

    F is the residual flexibility, f the interface forces. The modes that are not kept act as springs without
    mass: the matrices are those of Rubin in other coordinates, without the mass H of the residual shapes.
    They are not a projection on a basis, so `reduce` cannot use this method. As mass is missing, the
    eigenvalues are upper bounds, never below those of Rubin. Each further mode adds its mass and lowers the
    eigenvalues.

    ingredients : FreeInterfaceComponent
    Raises AccuracyError if the modes leave no residual flexibility, or interfaces are dependent.
    Source: [MacNeal1971].
    """

    ingredients: FreeInterfaceComponent

    def __post_init__(self):
        require_residual(self.ingredients, "MacNeal's method")

    def interfaces_free(self) -> ReducedMatrices:
        """The free modes alone: interfaces without mass and load have f = 0 and q_v = B Phi eta."""
        values = self.ingredients.eigenvalues
        return ReducedMatrices(np.diag(values), np.eye(values.size))

    def interfaces_fixed(self) -> ReducedMatrices:
        """Stiffness Lambda + (B Phi)^T F^-1 B Phi and unit mass in the modes eta; q_v = 0."""
        n = self.ingredients.eigenvalues.size
        return ReducedMatrices(self._stiffness()[:n, :n], np.eye(n))

    def interfaces_loaded(self, added_mass: np.ndarray) -> ReducedMatrices:
        """The stiffness K above, and the mass M = diag(I, added_mass), in (eta, q_v)."""
        n = self.ingredients.eigenvalues.size
        return ReducedMatrices(self._stiffness(), block_diagonal(np.eye(n), added_mass))

    def _stiffness(self) -> np.ndarray:
        motion = self.ingredients.interface_motion
        stretch = np.hstack([-motion, np.eye(len(motion))])
        springs = linalg.cho_solve(linalg.cho_factor(self.ingredients.residual_flexibility), stretch)
        stiffness = stretch.T @ springs
        n = self.ingredients.eigenvalues.size
        stiffness[range(n), range(n)] += self.ingredients.eigenvalues
        return 0.5 * (stiffness + stiffness.T)
