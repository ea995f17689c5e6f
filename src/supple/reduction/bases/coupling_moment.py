"""Mode ranking by moment matching at the interfaces: the criterion of the CMS-chi method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from supple.body import FlexibleBody
from supple.reduction.bases.mode_selection import ChosenModes, ranked_modes
from supple.reduction.components.fixed_interface_component import FixedInterfaceComponent

__all__ = ["CouplingMoment", "coupling_moments"]


@dataclass(frozen=True)
class CouplingMoment:
    """Keep the modes that contribute most to the dynamic stiffness of the interfaces.

        Z(s) = K_b - s M_b - s^2 sum_j S_j (1 + s / kappa_j + ...),    s = omega^2
        S_j = p_j^T p_j / kappa_j,    p_j = phi_j^T M Psi

    K_b, M_b: stiffness and mass of the constraint modes Psi; phi_j, kappa_j: fixed-interface modes and their
    eigenvalues.
    The modes of largest S_j are kept, so that the lowest moment of the truncated modes is smallest: the
    moment-matching principle of the CMS-chi method. The norm of S_j would depend on units, because
    translations and rotations mix. S_j is therefore measured relative to the interface mass,

        chi_j = p_j M_b^-1 p_j^T / kappa_j

    Let X be the sum of S_j over the truncated modes, lambda an eigenvalue of the free body and xi the
    interface motion of its vibration. Then lambda trace(M_b^-1 X), the sum of lambda chi_j over the truncated
    modes, bounds the first-order eigenvalue error lambda xi^T X xi of [Han2020] (45) if xi^T M_b xi <= 1.

    candidates : number of lowest modes to choose from
    Source: [LiaoBaiGao2007] for the principle, from which the formula is derived here; [Givoli2004] for modes
        ranked by their contribution to the interface.
    """

    candidates: int

    def scores(self, body: FlexibleBody, component: FixedInterfaceComponent) -> np.ndarray:  # noqa: ARG002
        """The coupling moments chi_j, (m,), s^2/rad^2."""
        return coupling_moments(component)

    def choose(self, body: FlexibleBody, n_modes: int) -> ChosenModes:
        """The n_modes of largest coupling moment; ModelError when there are fewer candidates."""
        return ranked_modes(self, body, n_modes)


def coupling_moments(component: FixedInterfaceComponent) -> np.ndarray:
    """chi_j = p_j M_b^-1 p_j^T / kappa_j of every mode, (m,)."""
    scaled = linalg.cho_solve(linalg.cho_factor(component.interface_mass), component.participation.T)
    return np.sum(component.participation.T * scaled, axis=0) / component.eigenvalues
