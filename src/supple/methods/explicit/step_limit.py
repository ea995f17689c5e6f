"""Longest stable step of central differences on a modal sub-domain.

    (27)   dt <= 2 / omega_max,   K_L y = omega^2 M_V y

holds for modes that are M-orthogonal to rigid motion. With other bases the frame's points move in vibration,
which reduces the effective mass of the modes; then the limit is that of the true pencil

    K_L y = omega^2 (M_V - M_C R (R^T M_E R)^-1 R^T M_C^T) y,   R the six rigid motions of the points.

The limit does not depend on the rotation, so it is computed once. Source: [Radioss] (26)-(27), corrected.
"""

from __future__ import annotations

import numpy as np
from scipy import linalg

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.methods.explicit.frame_moments import Moments
from supple.methods.explicit.frame_points import FramePoints


def local_limit(moments: Moments, arm: float, stiffness: FloatArray) -> float:
    """Limit (27) of the modes alone, s; stiffness (k, k)."""
    return _limit(stiffness, local_mass(moments, arm))


def true_limit(moments: Moments, points: FramePoints, stiffness: FloatArray) -> float:
    """Limit of modes and frame together, s; stiffness (k, k)."""
    return _limit(stiffness, free_modal_mass(mass_of_motions(moments, points)))


def mass_of_motions(moments: Moments, points: FramePoints) -> FloatArray:
    """Mass matrix (6 + k, 6 + k) of rigid motion and modes, in the mesh axes."""
    rigid, S1 = points.rigid_rates.reshape(12, 6), np.asarray(moments.S1)
    k = S1.shape[2]
    M = np.zeros((6 + k, 6 + k))
    M[:6, :6] = rigid.T @ np.kron(np.asarray(moments.S0), np.eye(3)) @ rigid
    M[:6, 6:] = rigid.T @ (points.arm * S1.reshape(12, -1))
    M[6:, :6] = M[:6, 6:].T
    M[6:, 6:] = local_mass(moments, points.arm)
    return M


def free_modal_mass(mass: FloatArray) -> FloatArray:
    """Mass (k, k) of the modes with a free frame, from that of rigid motion and modes."""
    return mass[6:, 6:] - mass[6:, :6] @ np.linalg.solve(mass[:6, :6], mass[:6, 6:])


def damped_limit(limit: float, stiffness_factor: float) -> float:
    """Limit with damping beta K that lags by half a step, s: 2/omega (sqrt(1 + zeta^2) - zeta)."""
    zeta = stiffness_factor / limit
    return limit * float(np.hypot(1.0, zeta) - zeta)


def local_mass(moments: Moments, arm: float) -> FloatArray:
    """Modal mass M_V (k, k)."""
    return arm**2 * np.einsum("iikl->kl", np.asarray(moments.C))


def _limit(stiffness: FloatArray, mass: FloatArray) -> float:
    if not len(stiffness):
        return float("inf")
    try:
        largest = linalg.eigh(stiffness, mass, eigvals_only=True)[-1]
    except linalg.LinAlgError:
        raise ModelError(
            "the modes of a sub-domain contain rigid motion, which its frame already has: make them "
            "M-orthogonal to it, as modal_subdomain does"
        ) from None
    return float(2 / np.sqrt(largest)) if largest > 0 else float("inf")
