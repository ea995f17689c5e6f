"""Rank of fixed-interface modes by moment matching at the interfaces, as in the CMS-chi method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from supple.body import FlexibleBody
from supple.reduction.bases.mode_selection import RankedModes
from supple.reduction.components.fixed_interface_component import FixedInterfaceComponent

__all__ = ["CouplingMoment", "coupling_moments"]


@dataclass(frozen=True)
class CouplingMoment(RankedModes):
    """Keep the modes that contribute most to the dynamic stiffness of the interfaces.

        Z(s) = K_b - s M_b - s^2 sum_j S_j (1 + s / kappa_j + ...),    s = omega^2
        S_j = p_j^T p_j / kappa_j,    p_j = phi_j^T M Psi

    Z is the dynamic stiffness; K_b, M_b are stiffness and mass of the constraint modes Psi; phi_j, kappa_j
    are the fixed-interface modes and their eigenvalues. S_j is the lowest moment of mode j. The CMS-chi
    method keeps the modes of largest S_j. A norm of S_j would depend on units, because its entries belong to
    translations and rotations. The modes are therefore ranked by S_j relative to the interface mass:

        chi_j = p_j M_b^-1 p_j^T / kappa_j

    Let X be the sum of S_j over the modes that are not kept, lambda an eigenvalue of the free body, and xi
    the interface motion of its vibration. The first-order error of lambda is lambda xi^T X xi, [Han2020]
    (45). If xi^T M_b xi <= 1, it is at most lambda trace(M_b^-1 X), the sum of lambda chi_j over these modes.

    Source: [LiaoBaiGao2007] for the principle, from which the formula is derived here; [Givoli2004] for modes
        ranked by their contribution to the interface.
    """

    def scores(self, body: FlexibleBody, component: FixedInterfaceComponent) -> np.ndarray:  # noqa: ARG002
        """The coupling moments chi_j, (m,), s^2/rad^2."""
        return coupling_moments(component)


def coupling_moments(component: FixedInterfaceComponent) -> np.ndarray:
    """chi_j = p_j M_b^-1 p_j^T / kappa_j of every mode, (m,)."""
    scaled = linalg.cho_solve(linalg.cho_factor(component.interface_mass), component.participation.T)
    return np.sum(component.participation.T * scaled, axis=0) / component.eigenvalues
