"""Fixed-interface vibrations of a body: the matrices of Craig-Bampton and its variants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra import ReadOnlyArrays, RitzModes
from supple.body import FlexibleBody
from supple.errors import ModelError
from supple.reduction.bases.guyan import interface_shapes
from supple.reduction.bases.interface_columns import motion_rows, require_interfaces
from supple.reduction.bases.linear_basis import check_mode_count
from supple.reduction.components.component_model import RitzComponent, block_diagonal
from supple.reduction.components.deflation import SMALLEST_RESIDUAL, residual_response, residual_shares

__all__ = [
    "FixedInterfaceComponent",
    "craig_bampton_component",
    "enhanced_component",
    "fixed_interface_component",
    "fixed_interface_modes",
    "residual_component",
]


@dataclass(frozen=True, eq=False)
class FixedInterfaceComponent(ReadOnlyArrays):
    """Matrices in constraint modes Psi and fixed-interface modes Phi, with the residual of truncated modes.

        u = Psi q_v + Phi eta,   A = M Psi

    eigenvalues : (m,)                  rad^2/s^2
    participation : (m, b)              Phi^T A, b = 6 n_interfaces
    interface_stiffness : (b, b)        Psi^T K Psi
    interface_mass : (b, b)             Psi^T M Psi
    residual_flexibility : (b, b)       X = A^T F_rs A, F_rs = K_s^-1 - Phi Lambda^-1 Phi^T
    residual_mass : (b, b)              X2 = Y^T M Y, Y = F_rs A
    """

    eigenvalues: np.ndarray
    participation: np.ndarray
    interface_stiffness: np.ndarray
    interface_mass: np.ndarray
    residual_flexibility: np.ndarray
    residual_mass: np.ndarray

    @property
    def n_modes(self) -> int:
        """Number m of modes."""
        return self.eigenvalues.size

    @property
    def residual_shares(self) -> np.ndarray:
        """Ratio (b,) of residual to whole flexibility, under the inertia of each interface acceleration."""
        return residual_shares(self.residual_flexibility, self.participation, self.eigenvalues)

    def keeping(self, modes: np.ndarray) -> FixedInterfaceComponent:
        """The same body with the modes of given indices (m',); the removed modes join the residual, exactly.

        For removed modes of participation a, X grows by sum a a^T / kappa and X2 by sum a a^T / kappa^2.
        """
        given_up = np.setdiff1d(np.arange(self.n_modes), modes)
        values, motion = self.eigenvalues[given_up], self.participation[given_up].T
        return FixedInterfaceComponent(
            self.eigenvalues[modes],
            self.participation[modes],
            self.interface_stiffness,
            self.interface_mass,
            self.residual_flexibility + (motion / values) @ motion.T,
            self.residual_mass + (motion / values**2) @ motion.T,
        )

    def leading(self, n_modes: int) -> FixedInterfaceComponent:
        """The same body with its n_modes lowest modes; ModelError when there are fewer."""
        if not 0 <= n_modes <= self.n_modes:
            raise ModelError(f"{n_modes} modes requested of a component that has {self.n_modes}")
        return self.keeping(np.arange(n_modes))


def fixed_interface_modes(body: FlexibleBody, n_modes: int) -> RitzModes:
    """The lowest vibrations with every interface fixed; ModelError: no interface, or fewer modes."""
    require_interfaces(body, "a vibration with fixed interfaces")
    clamped = motion_rows(body.independent_interfaces)
    check_mode_count(body, n_modes, len(clamped))
    return RitzModes.of(body.lowest_modes(n_modes, clamped))


def fixed_interface_component(body: FlexibleBody, modes: RitzModes) -> FixedInterfaceComponent:
    """The component of given fixed-interface modes of a body, with the residual of all other modes.

    Raises ModelError when the body has no interface.
    Source: [CraigBampton1968], [Han2020] (11)-(26).
    """
    Psi = interface_shapes(body)
    A = body.mass @ Psi
    clamped = body.constrained(motion_rows(body.independent_interfaces))
    residual = residual_response(clamped, body.mass, modes, A)
    stiffness, mass = Psi.T @ (body.stiffness @ Psi), Psi.T @ A
    return FixedInterfaceComponent(
        eigenvalues=modes.values,
        participation=modes.participation(A),
        interface_stiffness=0.5 * (stiffness + stiffness.T),
        interface_mass=0.5 * (mass + mass.T),
        residual_flexibility=residual.flexibility,
        residual_mass=residual.mass,
    )


def craig_bampton_component(component: FixedInterfaceComponent) -> RitzComponent:
    """Craig and Bampton's matrices in (q_v, eta).

    K = [ K_b  0      ]     M = [ M_b  P^T ]      P = Phi^T A
        [ 0    Lambda ]         [ P    I   ]
    """
    b = len(component.interface_mass)
    P = component.participation
    return RitzComponent(
        stiffness=block_diagonal(component.interface_stiffness, np.diag(component.eigenvalues)),
        mass=np.block([[component.interface_mass, P.T], [P, np.eye(len(P))]]),
        interface_motion=np.eye(b, b + len(P)),
    )


def residual_component(component: FixedInterfaceComponent) -> RitzComponent:
    """Craig and Bampton's matrices with the residual modes Y as columns of their own, in (q_v, eta, zeta).

        K = diag(K_b, Lambda, X),   Psi^T M Y = A^T F_rs A = X,   Phi^T M Y = 0,   Y^T M Y = X2

    Residual modes that are round-off compared with the vibrations are dropped.
    """
    plain = craig_bampton_component(component)
    left = component.residual_shares > SMALLEST_RESIDUAL
    X, X2 = component.residual_flexibility[:, left], component.residual_mass[np.ix_(left, left)]
    coupling = np.vstack([X, np.zeros((component.n_modes, X.shape[1]))])
    return RitzComponent(
        stiffness=block_diagonal(plain.stiffness, X[left]),
        mass=np.block([[plain.mass, coupling], [coupling.T, X2]]),
        interface_motion=np.hstack([plain.interface_motion, np.zeros_like(X)]),
    )


def enhanced_component(component: FixedInterfaceComponent) -> RitzComponent:
    """Kim and Lee's enhanced Craig-Bampton: the residual modes without coordinates of their own.

        u = [Psi Phi] x + Y E M^-1 K x,    E x = q_v

    The matrix E M^-1 K, with the Craig-Bampton matrices K, M of the free body, replaces omega^2 in Psi +
    omega^2 Y; E selects q_v. The result is a Ritz basis with as many coordinates as Craig-Bampton, but
    specific to free interfaces: for a body joined to another one, these matrices would be different.
    Source: [KimLee2015], [Han2020] (26) and Appendix A.
    """
    plain, wide = craig_bampton_component(component), residual_component(component)
    left = component.residual_shares > SMALLEST_RESIDUAL
    amplitude = np.linalg.solve(plain.mass, plain.stiffness)[: left.size][left]
    columns = np.vstack([np.eye(len(plain.mass)), amplitude])
    return RitzComponent(
        stiffness=columns.T @ wide.stiffness @ columns,
        mass=columns.T @ wide.mass @ columns,
        interface_motion=plain.interface_motion,
    )
