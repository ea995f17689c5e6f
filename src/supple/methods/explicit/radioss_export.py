"""A modal sub-domain as the contents of Radioss' flexible-body file."""

from __future__ import annotations

import numpy as np

from supple.importers.radioss import FlexibleBodyFile
from supple.methods.explicit.modal_subdomain import ModalSubdomain


def flexible_body_file(body: ModalSubdomain) -> FlexibleBodyFile:
    """Frame modes, local modes, and the constant matrices of [Radioss] (23)-(25), in the axes of the mesh.

    The four points have arms of the radius of gyration: P0 = arm * I. Nodes have translations only.
    """
    points, own = body.points, body.body
    k, N = body.n_modes, len(own.nodes)
    weights = points.weights(own.nodes)
    frame_modes = np.zeros((12, N, 6))
    for a in range(4):
        for i in range(3):
            frame_modes[3 * a + i, :, i] = weights[:, a]
    modes = np.zeros((k, N, 6))
    modes[:, :, :3] = body.shapes.transpose(2, 0, 1) * points.arm
    forces = own.expansion @ (own.stiffness @ body.vectors)
    local = forces.reshape(N, own.dofs_per_node, k)[:, :3] / points.arm
    S0, S1 = np.asarray(body.moments.S0), np.asarray(body.moments.S1)
    pulled = np.einsum("na,nlk->alk", weights, local, optimize=True)
    ids = np.arange(1, N + 1) if own.model is None else own.model.mesh.node_ids
    return FlexibleBodyFile(
        node_ids=np.asarray(ids),
        frame=points.arm * np.eye(3),
        highest_frequency=float(body.frequencies[-1] / (2 * np.pi)),
        modes=modes,
        mass=np.ones(k),
        stiffness=np.diag(body.frequencies**2),
        frame_modes=frame_modes,
        frame_mass=np.asarray(np.kron(S0, np.eye(3)), dtype=np.float64),
        coupling_mass=_nine(S1),
        coupling_stiffness=_nine(pulled),
        damping=(body.mass_damping, body.stiffness_damping)
        if body.mass_damping or body.stiffness_damping
        else None,
    )


def _nine(sums: np.ndarray) -> np.ndarray:
    """(9, k, 12): the coupling that multiplies P_il, from sums (4, 3, k) over w_a and Phi_l."""
    k = sums.shape[2]
    parts = np.zeros((3, 3, k, 4, 3))
    for i in range(3):
        for row in range(3):
            parts[i, row, :, :, i] = sums[:, row].T
    return parts.reshape(9, k, 12)
