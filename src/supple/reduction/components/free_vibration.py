"""Vibrations of a free Craig-Bampton body, computed in its interface and modal coordinates."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy import linalg

from supple.algebra import ReadOnlyArrays
from supple.reduction.components.fixed_interface_component import FixedInterfaceComponent

__all__ = ["FreeVibrations", "free_vibrations"]


@dataclass(frozen=True, eq=False)
class FreeVibrations(ReadOnlyArrays):
    """The lowest elastic vibrations u = Psi xi + Phi eta of a free Craig-Bampton body, of unit modal mass.

    values     : (N,)     eigenvalues chi-bar, rad^2/s^2, ascending; the six rigid motions are not counted
    interfaces : (b, N)   xi, interface motions
    modal      : (d, N)   eta, amounts of the d fixed-interface modes
    """

    values: np.ndarray
    interfaces: np.ndarray = field(repr=False)
    modal: np.ndarray = field(repr=False)


def free_vibrations(
    component: FixedInterfaceComponent, rigid_motion: np.ndarray, n_vibrations: int
) -> FreeVibrations:
    """The lowest vibrations of Craig and Bampton's matrices, with rigid motion removed exactly.

        K-bar = [[K_b, 0], [0, Lambda]],     M-bar = [[M_b, P^T], [P, 1]],     K-bar x = chi-bar M-bar x

    The first interface is fixed, the others move; a rigid motion is added to each column, so that the column
    is M-orthogonal to all rigid motions. Then K-bar is scaled to the unit matrix, and M-bar x = (1/chi-bar)
    K-bar x is solved: round-off disturbs the largest eigenvalues 1/chi-bar, those of the lowest vibrations,
    least.

    component    : FixedInterfaceComponent   with d modes
    rigid_motion : (b, 6)                    B R, the interfaces in a rigid motion of the body
    n_vibrations : N; fewer are returned where the reduced body has fewer, d + b - 6
    """
    moving = slice(6, len(rigid_motion))
    n_moving, n_modes = len(rigid_motion) - 6, component.n_modes
    size = n_moving + n_modes
    if size == 0:
        return FreeVibrations(np.zeros(0), np.zeros((6, 0)), np.zeros((0, 0)))
    root = np.linalg.cholesky(rigid_motion.T @ component.interface_mass @ rigid_motion)
    G = linalg.solve_triangular(root, rigid_motion.T, lower=True).T
    P = component.participation
    coupling = np.hstack([G.T @ component.interface_mass[:, moving], G.T @ P.T])
    mass = np.block(
        [[component.interface_mass[moving, moving], P[:, moving].T], [P[:, moving], np.eye(n_modes)]]
    )
    mass -= coupling.T @ coupling

    unscale = linalg.block_diag(
        np.linalg.inv(np.linalg.cholesky(component.interface_stiffness[moving, moving])).T,
        np.diag(1 / np.sqrt(component.eigenvalues)),
    )
    scaled = unscale.T @ mass @ unscale
    mu, columns = linalg.eigh(
        0.5 * (scaled + scaled.T), subset_by_index=(max(size - n_vibrations, 0), size - 1)
    )
    mu, columns = mu[::-1], columns[:, ::-1]
    amounts = unscale @ (columns / np.sqrt(mu))
    interfaces = -G @ (coupling @ amounts)
    interfaces[moving] += amounts[:n_moving]
    return FreeVibrations(1 / mu, interfaces, amounts[n_moving:])
