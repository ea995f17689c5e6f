"""Matrix of the kinetic energy of a body that moves and deforms in a floating frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body.flexible_body import FlexibleBody
from supple.body.inertia_polynomial import InertiaPolynomial
from supple.body.rigid_motion import cross_of_axes
from supple.errors import ModelError

__all__ = ["inertia_gram"]

_BLOCK_NUMBERS = 2**22
"""Largest number of values of a block of columns in memory at a time; each column needs nine fields (n,)."""


def inertia_gram(body: FlexibleBody, basis: ArrayLike) -> NDArray[np.float64]:
    """Matrix G of the kinetic energy of a body with the deformation V gamma, in axes of the frame.

        z = (v, w, gamma_1 w, ..., gamma_r w, gamma'),    T = 1/2 z^T G z

    v, w are the velocity and angular velocity of the frame. With only nodal point masses, G is the Gram
    matrix W^T M W of the fields W = [Phi_t | Phi_w0 | Phi_1 ... Phi_r | V]: unit translations, unit
    rotations, e_i x V_k (three columns each) and the basis. Rotary inertia adds to the blocks of G, to second
    order in the rotations (`InertiaPolynomial`).

    Parameters
    ----------
    basis : (n, r)   V in the body's coordinates
    Returns
    -------
    (6 + 4 r, 6 + 4 r)   symmetric
    Raises
    ------
    ModelError   a basis of another shape
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
    # From the nodal mass, so that a difference between nodal_mass and mass is visible in the result. Modal
    # coordinates are not in the nodal mass and need body.mass.
    nodal = V if body.n_modal else body.expansion @ V
    own = nodal.T @ ((body.mass if body.n_modal else body.nodal_mass) @ nodal)
    gram = np.block([[rigid, turned, by_basis], [turned.T, among, rates], [by_basis.T, rates.T, own]])
    return 0.5 * (gram + gram.T)
