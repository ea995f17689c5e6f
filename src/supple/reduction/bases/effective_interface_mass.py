"""Effective interface mass: share of a fixed-interface mode in the inertia at the interfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra import factorize_symmetric
from supple.body import FlexibleBody
from supple.reduction.bases.interface_columns import motion_rows
from supple.reduction.bases.mode_selection import RankedModes
from supple.reduction.components.fixed_interface_component import FixedInterfaceComponent

__all__ = ["EffectiveInterfaceMass", "effective_interface_masses", "interior_interface_mass"]

# M_e is scaled to a unit diagonal. An eigenvector moves no interior mass if its eigenvalue is up to this.
SMALLEST_SHARE = 1e-10


@dataclass(frozen=True)
class EffectiveInterfaceMass(RankedModes):
    """Keep the modes with the largest effective interface mass.

        e_j = p_j M_e^+ p_j^T / rank M_e,   p_j = phi_j^T M Psi,   M_e = sum of p_j^T p_j over all modes

    phi_j are the fixed-interface modes, Psi the constraint modes of all motions of all interfaces, and M_e^+
    is the pseudo-inverse of M_e. p_j^T p_j generalises the effective modal mass of a body clamped at one
    support. The shares e_j depend neither on the units of translation and rotation nor on the axes of the
    interfaces. The sum of all e_j is one.

    Source: [KammerTriller1996]; the scaling is derived here.
    """

    def scores(self, body: FlexibleBody, component: FixedInterfaceComponent) -> np.ndarray:
        """The effective interface masses e_j, (m,)."""
        return effective_interface_masses(component, interior_interface_mass(body, component))


def effective_interface_masses(component: FixedInterfaceComponent, total: np.ndarray) -> np.ndarray:
    """Shares e_j (m,) of the modes in the total interface mass M_e (b, b); they sum to 1 over all modes."""
    scale = 1.0 / np.sqrt(np.diag(total))
    masses, directions = np.linalg.eigh(scale[:, None] * total * scale)
    carried = masses > SMALLEST_SHARE
    shares = (component.participation * scale) @ directions[:, carried] / np.sqrt(masses[carried])
    return np.sum(shares**2, axis=1) / np.sum(carried)


def interior_interface_mass(body: FlexibleBody, component: FixedInterfaceComponent) -> np.ndarray:
    """Sum M_e (b, b) of p_j^T p_j over all fixed-interface modes, which need not be computed.

        M_e = Psi^T M Psi - (B M^-1 B^T)^-1

    The first term is the mass of the constraint modes. The second is the interface mass at infinite
    frequency, where elastic forces do not act; with a lumped mass matrix it is the mass of the interface
    nodes. M is factored once.
    """
    B = motion_rows(body.independent_interfaces)
    mobility = B @ factorize_symmetric(body.mass).solve(B.T)
    total = component.interface_mass - np.linalg.inv(0.5 * (mobility + mobility.T))
    return 0.5 * (total + total.T)
