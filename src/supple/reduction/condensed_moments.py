"""Moments of the condensed motion about the frame: what its leading inertia is made of."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.body import FlexibleBody
from supple.body.rigid_motion import nodal_rigid_modes

Array = NDArray[np.float64]


def condensed_moments(body: FlexibleBody, fields: Array, amplitudes: Array) -> Array:
    """Second derivatives by the coordinates of the moments of z, (12, r(r+1)/2), packed in pairs.

        s = Phi_t^T M z,   c = Phi_w0^T M z,   J_ij = Phi_w0,i^T M (e_j x z) + Phi_w0,j^T M (e_i x z), i <= j

    Phi_t, Phi_w0: unit translations and rotations of the undeformed body; e_j x z on translations alone, as in
    `inertia_gram`. So the change of the kinetic energy of a rotation w is w J w / 2 to first order in z.

    body : FlexibleBody
    fields : (n_nodal, m);  amplitudes : (m, r(r+1)/2)     of a `CondensedMotion`
    """
    d, n_nodes = body.dofs_per_node, len(body.nodes)
    momenta = body.nodal_mass @ nodal_rigid_modes(body.nodes, d)
    of_rotation = momenta.reshape(n_nodes, d, 6)[:, :3, 3:]
    first, second = np.triu_indices(3)
    unit = np.eye(3)
    weights = np.zeros((n_nodes, d, 12))
    weights.reshape(-1, 12)[:, :6] = momenta
    for k, (i, j) in enumerate(zip(first, second, strict=True)):
        # b . (e x z) = z . (b x e)
        weights[:, :3, 6 + k] = np.cross(of_rotation[:, :, i], unit[j]) + np.cross(
            of_rotation[:, :, j], unit[i]
        )
    moments = (weights.reshape(-1, 12).T @ fields) @ amplitudes
    r = int(np.sqrt(2 * amplitudes.shape[1]))
    on_diagonal = np.equal(*np.triu_indices(r))
    return moments * np.where(on_diagonal, 2.0, 1.0)
