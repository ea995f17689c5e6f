"""Sums over the mass of a modal sub-domain: the complete inertia of its equations of motion.

Every nodal sum is a polynomial in the modal coordinates y, so three constant arrays replace the nodes:

    S0 = sum m w w^T,     S1 = sum m w Phi,     C = sum m Phi Phi

A step then costs O(9 k^2), independent of the mesh.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from supple.algebra import jax_settings  # noqa: F401 - 64-bit floats, before the first array
from supple.methods.explicit.frame_points import CORNERS
from supple.methods.explicit.mass_fields import MassFields


class Moments(NamedTuple):
    """Constant sums of a sub-domain of k modes.

    S0 : (4, 4) kg;   S1 : (4, 3, k) kg;   C : (3, 3, k, k) kg, C_ijkl = sum m Phi_ik Phi_jl
    """

    S0: Array
    S1: Array
    C: Array

    def __add__(self, other: Moments) -> Moments:  # ty: ignore[incompatible-method-override] - sums, as tuples do not
        """Sums over the mass of both."""
        return Moments(*(a + b for a, b in zip(self, other, strict=True)))


class Spread(NamedTuple):
    """Sums in a deformed state, with the local displacement u = Phi y.

    Xi : (4, 4)     sum m xi xi^T, kg, xi = w + CORNERS u
    Q : (4, 3, k)   sum m xi_a Phi_lk, kg
    """

    Xi: Array
    Q: Array


def moments(fields: MassFields) -> Moments:
    """Sums over mass fields."""
    w, phi = fields.weights, fields.shapes
    k = phi.shape[2]
    flat = phi.reshape(len(w), -1)
    Mw, Mphi = fields.mass @ w, fields.mass @ flat
    C = (flat.T @ Mphi).reshape(3, k, 3, k).transpose(0, 2, 1, 3)
    return Moments(jnp.asarray(w.T @ Mw), jnp.asarray((Mw.T @ flat).reshape(4, 3, k)), jnp.asarray(C))


def spread(of: Moments, y: Array) -> Spread:
    """Sums over the body deformed by y (k,)."""
    E = jnp.asarray(CORNERS)
    Cy = of.C @ y  # (3, 3, k): sum m Phi_ik u_j
    U = of.S1 @ y  # (4, 3): sum m w u
    cross = U @ E.T
    Xi = of.S0 + cross + cross.T + E @ (y @ Cy.transpose(2, 0, 1).reshape(len(y), 9)).reshape(3, 3) @ E.T
    Q = of.S1 + jnp.einsum("aj,ljk->alk", E, Cy)
    return Spread(Xi, Q)


def arms(p: Array) -> Array:
    """P (3, 3), columns x_A - x_O, x_B - x_O, x_C - x_O, of points p (4, 3)."""
    return (p[1:] - p[0]).T
