"""Free vibrations of a body: the matrices of Rubin's, MacNeal's and the dual Craig-Bampton method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from supple.algebra import ReadOnlyArrays, RitzModes
from supple.body import FlexibleBody, MeanAxisFrame
from supple.errors import AccuracyError, ModelError
from supple.reduction.bases.interface_columns import motion_rows, require_interfaces
from supple.reduction.bases.linear_basis import check_mode_count
from supple.reduction.components.component_model import RitzComponent, block_diagonal
from supple.reduction.components.deflation import SMALLEST_RESIDUAL, residual_response, residual_shares

__all__ = ["FreeInterfaceComponent", "free_interface_component", "free_interface_modes", "rubin_component"]


@dataclass(frozen=True, eq=False)
class FreeInterfaceComponent(ReadOnlyArrays):
    """Interface motions of the free-interface modes, and the residual of all other modes at the interfaces.

        u = R a + Phi eta + G_r B^T f,    G_r = G - Phi Lambda^-1 Phi^T,   f forces at the interfaces

    G gives the response to self-equilibrated loads in the mean-axis frame (inertia relief). The six rigid
    motions, made M-orthonormal, come first among the modes, with eigenvalue zero.

    eigenvalues : (6 + m,)              rad^2/s^2
    interface_motion : (b, 6 + m)       B [R Phi]
    residual_flexibility : (b, b)       F = B G_r B^T
    residual_mass : (b, b)              H = B G_r M G_r B^T
    """

    eigenvalues: np.ndarray
    interface_motion: np.ndarray
    residual_flexibility: np.ndarray
    residual_mass: np.ndarray

    @property
    def n_modes(self) -> int:
        """Number m of elastic modes."""
        return self.eigenvalues.size - 6

    @property
    def residual_shares(self) -> np.ndarray:
        """Ratio (b,) of residual to whole elastic flexibility at each interface freedom."""
        return residual_shares(self.residual_flexibility, self.interface_motion.T[6:], self.eigenvalues[6:])

    def leading(self, n_modes: int) -> FreeInterfaceComponent:
        """The same body with its n_modes lowest elastic modes; the others join the residual, exactly.

        Over the removed modes, F grows by (B Phi) Lambda^-1 (B Phi)^T and H by (B Phi) Lambda^-2 (B Phi)^T.
        Raises ModelError when there are fewer modes.
        """
        if not 0 <= n_modes <= self.n_modes:
            raise ModelError(f"{n_modes} modes requested of a component that has {self.n_modes}")
        kept = 6 + n_modes
        values, motion = self.eigenvalues[kept:], self.interface_motion[:, kept:]
        return FreeInterfaceComponent(
            self.eigenvalues[:kept],
            self.interface_motion[:, :kept],
            self.residual_flexibility + (motion / values) @ motion.T,
            self.residual_mass + (motion / values**2) @ motion.T,
        )


def free_interface_modes(body: FlexibleBody, n_modes: int) -> RitzModes:
    """The lowest elastic vibrations of the free body, R^T M Phi = 0; ModelError when it has fewer."""
    check_mode_count(body, n_modes, n_fixed=6)
    mean_axis = MeanAxisFrame().constraint(body)
    return RitzModes.of(body.lowest_modes(n_modes, mean_axis))


def free_interface_component(body: FlexibleBody, modes: RitzModes) -> FreeInterfaceComponent:
    """The component of given free-interface modes of a body, with the residual of all other modes.

    Raises ModelError when the body has no interface.
    Source: [Rubin1975], [Rixen2004].
    """
    require_interfaces(body, "a free-interface component")
    B = motion_rows(body.independent_interfaces)
    relieved = body.constrained(MeanAxisFrame().constraint(body))
    residual = residual_response(relieved, body.mass, modes, B.T)
    cholesky = np.linalg.cholesky(body.rigid_modes.T @ (body.mass @ body.rigid_modes))
    rigid = linalg.solve_triangular(cholesky, body.rigid_modes.T, lower=True).T
    return FreeInterfaceComponent(
        eigenvalues=np.concatenate([np.zeros(6), modes.values]),
        interface_motion=np.hstack([B @ rigid, modes.participation(B.T).T]),
        residual_flexibility=residual.flexibility,
        residual_mass=residual.mass,
    )


def require_residual(component: FreeInterfaceComponent, method: str) -> None:
    """AccuracyError when the residual flexibility, which a method inverts, is singular.

    Either the modes leave no residual flexibility at an interface, or interfaces are dependent, such as two
    interfaces joined by a rigid part.
    """
    shares = component.residual_shares
    if not np.min(shares) > SMALLEST_RESIDUAL:
        raise AccuracyError(
            f"{method} needs a residual flexibility, but {component.n_modes} modes leave the share "
            f"{np.min(shares):.1e} of it at interface freedom {int(np.argmin(shares))}; "
            "keep fewer modes, or use Rubin"
        )
    lengths = np.sqrt(np.diag(component.residual_flexibility))
    smallest = np.linalg.eigvalsh(component.residual_flexibility / np.outer(lengths, lengths))[0]
    if not smallest > SMALLEST_RESIDUAL:
        raise AccuracyError(
            f"{method} needs independent interfaces, but some have no residual flexibility beside "
            f"that of others (share {smallest:.1e}); keep fewer modes, or use Rubin"
        )


def rubin_component(component: FreeInterfaceComponent) -> RitzComponent:
    """Rubin's matrices: the residual shapes G_r B^T are columns of the basis, with their mass.

        K = diag(Lambda, F),   M = diag(I, H),   q_v = [B Phi, F] x

    Shapes that are round-off compared with the modes are dropped.
    """
    left = component.residual_shares > SMALLEST_RESIDUAL
    F, H = component.residual_flexibility[:, left], component.residual_mass[np.ix_(left, left)]
    return RitzComponent(
        stiffness=block_diagonal(np.diag(component.eigenvalues), F[left]),
        mass=block_diagonal(np.eye(component.eigenvalues.size), H),
        interface_motion=np.hstack([component.interface_motion, F]),
    )
