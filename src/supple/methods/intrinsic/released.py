"""Intrinsic body with a free root, from the modes on its root support, for joints at any station."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import linalg

from supple.algebra import read_only
from supple.errors import AccuracyError, ModelError
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.intrinsic_modes import IntrinsicModes, checked_modes
from supple.methods.intrinsic.root_support import FREE

__all__ = ["released"]


LARGEST_CONDITION = 1e12
"""Largest condition number of the Gram matrix of rigid and elastic modes; a larger one is an error."""


def released(body: IntrinsicBody) -> IntrinsicBody:
    """The same body with a free root: rigid motion R and the elastic modes Phi_1 on its support.

    The modes of a free body have zero force at its root, and converge slowly if a joint acts there. The modes
    of the supported body have a force there. V = [R, Phi_1] is orthogonalised:

        V^T M V = L L^T,     L^-1 [0; w] = U S W^T,
        w <- S,     Phi_1 <- V L^-T U,     Phi_2 <- Phi_2 W,     C Phi_2 <- C Phi_2 W

    Phi_1 includes the static responses to forces and moments at the ends of the load paths. So the compliance
    at these ends is that of the line with all modes. The responses are omitted where modes that include them
    contain rigid motion or are not orthonormal. Ratios of ModalDamping, and alpha of RayleighDamping,
    remain those of the modes on the support.

    Raises ModelError if the elastic modes already include rigid motion; AccuracyError as `intrinsic_modes`.
    Source: [CraigBampton1968] for the choice of modes.
    """
    try:
        return _with_rigid_motion(body.with_static_responses())
    except (ModelError, AccuracyError):  # as for a root without mass
        return _with_rigid_motion(body)


def _with_rigid_motion(body: IntrinsicBody) -> IntrinsicBody:
    modes, line = body.modes, body.line
    e = modes.n_elastic
    omega = modes.omega[modes.n_rigid :]
    elastic = modes.velocities[..., modes.n_rigid :].reshape(-1, e)
    R = line.twists
    R = linalg.solve_triangular(np.linalg.cholesky(R.T @ line.mass @ R), R.T, lower=True).T
    V = np.hstack([R, elastic])
    gram = V.T @ line.mass @ V
    if np.linalg.cond(gram) > LARGEST_CONDITION:
        raise ModelError(
            f"body '{body.name}': its {e} elastic modes already include its rigid motion, since its root has "
            "no mass of its own: keep fewer modes (n_modes)"
        )
    lower = np.linalg.cholesky(gram)
    coupling = linalg.solve_triangular(lower, np.vstack([np.zeros((6, e)), np.diag(omega)]), lower=True)
    left, values, right = linalg.svd(coupling, full_matrices=False)
    order = np.argsort(values, kind="stable")
    left, values, W = left[:, order], values[order], right[order].T
    moving = V @ linalg.solve_triangular(lower, left, lower=True, trans=1)
    velocities = np.hstack([R, moving])
    own = IntrinsicModes(
        line=line,
        support=FREE,
        omega=read_only(np.append(np.zeros(6), values)),
        velocities=read_only(velocities.reshape(line.n, 6, -1)),
        momenta=read_only((line.mass @ velocities).reshape(line.n, 6, -1)),
        forces=read_only(modes.forces @ W),
        strains=read_only(modes.strains @ W),
        n_second_order=modes.n_second_order,
    )
    # Map of amplitudes -q_2 / w with equal strains, from the new modes to the old ones.
    amplitudes = (W * values) / omega[:, None]
    expansion = replace(
        body.expansion,
        modes=read_only(body.expansion.modes @ amplitudes),
        warping=read_only(body.expansion.warping @ amplitudes),
    )
    complete = None if body.complete is None else _released_or_none(body.complete)
    return replace(body, modes=checked_modes(own), expansion=expansion, complete=complete, supported=body)


def _released_or_none(whole: IntrinsicBody) -> IntrinsicBody | None:
    """The released body with all modes; None if these include rigid motion because the root has no mass."""
    try:
        return _with_rigid_motion(whole)
    except ModelError:
        return None
