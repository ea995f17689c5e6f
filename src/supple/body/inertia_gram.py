"""All inertia of a moving, deforming body in one Gram matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body.flexible_body import FlexibleBody
from supple.body.inertia_polynomial import InertiaPolynomial
from supple.body.rigid_motion import cross_of_axes
from supple.errors import ModelError

__all__ = ["inertia_gram"]

_BLOCK_NUMBERS = 2**22
"""Numbers in memory at once: nine fields for each column of a block."""


def inertia_gram(body: FlexibleBody, basis: ArrayLike) -> NDArray[np.float64]:
    """The matrix of the kinetic energy of a body whose deformation has the coordinates gamma of a basis.

        z = (v, w, gamma_1 w, ..., gamma_r w, gamma'),    T = 1/2 z^T G z

    With only nodal point masses it is the Gram matrix W^T M W of the fields
    W = [Phi_t | Phi_w0 | Phi_1 ... Phi_r | V]: unit translations, unit rotations, e_i x V_k (three columns
    each) and the basis. Rotary inertia adds to its blocks, to second order in the rotations
    (`InertiaPolynomial`).

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
    r, R = V.shape[1], body.rigid_modes
    energy = InertiaPolynomial(body)
    by_basis = (body.mass @ R).T @ V
    turned = np.zeros((6, r, 3))
    turned[:3] = np.moveaxis(cross_of_axes(by_basis[:3].T), 0, 1)
    turned[3:] = (energy.by_both @ V).swapaxes(1, 2)
    among, rates = np.zeros((r, 3, r, 3)), np.zeros((r, 3, r))
    at_once = max(1, _BLOCK_NUMBERS // (9 * max(body.n, 1)))
    for start in range(0, r, at_once):
        some = slice(start, start + at_once)
        fields = V[:, some]
        rates[:, :, some] = np.tensordot(V, energy.rate_products(fields)[1], axes=(0, 1))
        among[:, :, some] = np.tensordot(V, energy.spin_products(fields), axes=(0, 2)).swapaxes(2, 3)
    rigid, turned = R.T @ (body.mass @ R), turned.reshape(6, 3 * r)
    among, rates = among.reshape(3 * r, 3 * r), rates.reshape(3 * r, r)
    # The nodal mass shows a disagreement of the two masses; it lacks modal coordinates, which need the other.
    nodal = V if body.n_modal else body.expansion @ V
    own = nodal.T @ ((body.mass if body.n_modal else body.nodal_mass) @ nodal)
    gram = np.block([[rigid, turned, by_basis], [turned.T, among, rates], [by_basis.T, rates.T, own]])
    return 0.5 * (gram + gram.T)
