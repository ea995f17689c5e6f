"""All inertia of a moving, deforming body in one Gram matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body.flexible_body import FlexibleBody
from supple.body.rigid_motion import cross_of_axes, nodal_rigid_modes
from supple.errors import ModelError


def inertia_gram(body: FlexibleBody, basis: ArrayLike) -> NDArray[np.float64]:
    """The Gram matrix of the fields that nodal velocities are made of.

        W = [ Phi_t | Phi_w0 | Phi_1 ... Phi_r | V ],     G = W^T M W
        z = (v, w, gamma_1 w, ..., gamma_r w, gamma'),    T = 1/2 z^T G z

    Phi_t: unit translations. Phi_w0: e_i x x_a, with unit rotations on rotational freedoms. Phi_k: e_i x V_k
    on translations, zero on rotations, three columns each. V: the basis. All in the body's frame. M is the
    nodal mass; where its translational part couples nodes by a scalar times I_3, T is exact at any rotation.

    Parameters
    ----------
    basis : (n, r)   V in the body's coordinates
    Returns
    -------
    (6 + 4 r, 6 + 4 r)   symmetric
    Raises
    ------
    ModelError   wrong shape
    """
    V = np.asarray(basis, dtype=np.float64)
    if V.ndim != 2 or V.shape[0] != body.n:
        raise ModelError(f"the basis has shape {V.shape}; body '{body.name}' has {body.n} coordinates")
    r, d = V.shape[1], body.dofs_per_node
    N = len(body.nodes)
    nodal = (body.expansion @ V).reshape(N, d, r)
    W = np.zeros((N, d, 6 + 4 * r))
    W[:, :, :6] = nodal_rigid_modes(body.nodes, d).reshape(N, d, 6)
    turned = cross_of_axes(np.moveaxis(nodal[:, :3, :], 2, 1))  # (N, r, 3, 3): component, axis
    W[:, :3, 6 : 6 + 3 * r] = np.moveaxis(turned, 1, 2).reshape(N, 3, 3 * r)
    W[:, :, 6 + 3 * r :] = nodal
    W = W.reshape(N * d, 6 + 4 * r)
    gram = W.T @ (body.nodal_mass @ W)
    return 0.5 * (gram + gram.T)
