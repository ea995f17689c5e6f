"""Stiffness added to the modes by the centrifugal stress of a free, rotating body.

    K_G(Omega) = sum_ab Omega_a Omega_b K_ab,     K_ab = V^T K'(u_ab) V,     K u_ab = load of Omega_a Omega_b

summed over the six pairs ab of `PAIRS`, each product once. K'(u) is the derivative of the tangent stiffness
at rest in the direction u: the geometric stiffness of the stress that u causes, and initial-displacement
terms. Centrifugal loads are quadratic in the angular velocity, and stress is linear in the loads. So six
static solutions are sufficient for every angular velocity.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jax import Array

from supple.arrays import FloatArray
from supple.body import FlexibleBody
from supple.body.mass_properties import rigid_mass_properties
from supple.methods.explicit.frame_moments import arms

__all__ = ["CentrifugalStiffness"]


PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))
"""Axes a, b of the six products of angular velocities; each has one static solution."""


@dataclass(frozen=True)
class CentrifugalStiffness:
    """Stiffness of the modes by the centrifugal stress of free rotation about the centre of mass.

    The stress is that of the body alone: ties, contacts, loads and tied mass do not add to it.
    """

    def matrices(self, body: FlexibleBody, vectors: FloatArray) -> FloatArray:
        """K_ab (6, k, k), 1/s^2 per (rad/s)^2 for mass-normalised modes, in the order of `PAIRS`.

        Each load is in equilibrium with the inertia forces of the free body (inertia relief); the solution
        is M-orthogonal to rigid motion.

        vectors : (n, k)        V, in the coordinates of the body
        Raises ModelError for a body without quadratic strains.
        """
        assembly = body.assembly
        R, MR = body.rigid_modes, body.mass @ body.rigid_modes
        loads = centrifugal_loads(body)
        loads = loads - MR @ np.linalg.solve(R.T @ MR, R.T @ loads)
        moved = body.constrained(MR.T).solve(loads)
        found = [vectors.T @ (assembly.tangent_derivative(u) @ vectors) for u in moved.T]
        return np.array([0.5 * (each + each.T) for each in found])


def centrifugal_loads(body: FlexibleBody) -> FloatArray:
    """Loads (n, 6): coefficients of the products in `PAIRS` in m (|Omega|^2 X - Omega (Omega . X)).

    X is the position from the centre of mass.
    """
    X = body.nodes - rigid_mass_properties(body.nodal_mass, body.nodes, body.dofs_per_node).centre
    fields = np.zeros((len(X), body.dofs_per_node, 6))
    for number, (a, b) in enumerate(PAIRS):
        if a == b:
            fields[:, :3, number] = X
            fields[:, a, number] = 0.0
        else:
            fields[:, a, number] = -X[:, b]
            fields[:, b, number] = -X[:, a]
    return body.expansion.T @ (body.nodal_mass @ fields.reshape(-1, 6))


def spin_products(p: Array, rates: Array) -> Array:
    """Omega_a Omega_b (6,) in the axes of a frame of points p (4, 3), from the rates of its points."""
    P = arms(p)
    W = P.T @ arms(rates) / (P[:, 0] @ P[:, 0])
    spin = 0.5 * jnp.stack([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]])
    return jnp.stack([spin[a] * spin[b] for a, b in PAIRS])


def largest_of_unit_spin(matrices: FloatArray, mass: FloatArray) -> float:
    """Bound of the eigenvalues of K_G y = lambda M y, at 1 rad/s about any axis.

    Let c be the six components of Omega Omega^T, those off the diagonal times sqrt 2 and their K_i divided by
    sqrt 2. Then |c| = 1 at 1 rad/s, and |K_G| = |sum c_i K_i| <= sqrt(sum |K_i|^2).
    """
    factor = np.linalg.inv(np.linalg.cholesky(mass))
    sizes = np.linalg.norm(factor @ matrices @ factor.T, ord=2, axis=(1, 2))
    return float(np.linalg.norm(sizes / np.where([a == b for a, b in PAIRS], 1.0, np.sqrt(2.0))))


def spinning_step_limit(limit: Array, bound: Array, p: Array, rates: Array) -> Array:
    """Step limit of a rotating frame, s, from the limit at rest and the bound of `largest_of_unit_spin`."""
    squared = spin_products(p, rates)[:3].sum()
    return 2 / jnp.sqrt((2 / limit) ** 2 + bound * squared)
