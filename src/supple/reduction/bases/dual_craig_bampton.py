"""The dual Craig-Bampton method: free-interface modes, and the interface forces as unknowns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.reduction.components.component_model import ReducedMatrices, block_diagonal
from supple.reduction.components.free_interface_component import FreeInterfaceComponent, require_residual

__all__ = ["DualCraigBampton"]


@dataclass(frozen=True, eq=False)
class DualCraigBampton:
    """Matrices in the amplitudes eta of free-interface modes, and the interface forces f.

        u = Phi eta - G_r B^T f

        K = [ Lambda   (B Phi)^T ]     M = [ I  0 ]
            [ B Phi    -F        ]         [ 0  H ]

    f are the forces of the body on its supports. The residual flexibility F and its mass H are those of
    `FreeInterfaceComponent`. With fixed interfaces, the second row is B u + H f'' = 0: the interface motion
    B u is zero up to H f'', which decreases as modes are added. With neighbours, B u is replaced by the
    relative motion. K is indefinite, so Rayleigh's principle does not apply. Each force makes one eigenvalue
    negative; it belongs to no vibration. The other eigenvalues are upper bounds, and fall with every added
    mode. At s = omega^2 the coupling stiffnesses obey

        F^-1 - s F^-1 H F^-1  <=  (F + s H)^-1  <=  F^-1        (Rubin, dual, MacNeal),

    so that exact <= Rubin <= dual <= MacNeal holds for each eigenvalue.

    ingredients : FreeInterfaceComponent
    Raises AccuracyError if the modes leave no residual flexibility, or interfaces are dependent.
    Source: [Rixen2004]; the bounds are derived here.
    """

    ingredients: FreeInterfaceComponent

    def __post_init__(self):
        require_residual(self.ingredients, "the dual Craig-Bampton method")

    def interfaces_free(self) -> ReducedMatrices:
        """The free modes alone, without forces."""
        values = self.ingredients.eigenvalues
        return ReducedMatrices(np.diag(values), np.eye(values.size))

    def interfaces_fixed(self) -> ReducedMatrices:
        """The matrices K and M above, in (eta, f)."""
        parts = self.ingredients
        motion, F = parts.interface_motion, parts.residual_flexibility
        return ReducedMatrices(
            np.block([[np.diag(parts.eigenvalues), motion.T], [motion, -F]]),
            block_diagonal(np.eye(parts.eigenvalues.size), parts.residual_mass),
            n_forces=len(F),
        )

    def interfaces_loaded(self, added_mass: np.ndarray) -> ReducedMatrices:
        """Matrices with the motion v of bodies at the interfaces, in (eta, v, f): B u - v = 0."""
        parts = self.ingredients
        motion, F = parts.interface_motion, parts.residual_flexibility
        gap = np.hstack([motion, -np.eye(len(F))])
        own = block_diagonal(np.diag(parts.eigenvalues), np.zeros_like(F))
        return ReducedMatrices(
            np.block([[own, gap.T], [gap, -F]]),
            block_diagonal(np.eye(parts.eigenvalues.size), added_mass, parts.residual_mass),
            n_forces=len(F),
        )
