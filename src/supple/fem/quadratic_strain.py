"""Quadratic strain: the one form of all elements, and its energy, force, tangent and their derivatives.

At integration point g of an element with freedoms q (total Lagrangian, undeformed reference):

    eps_g(q) = B_g q + 1/2 N(G_g q, G_g q)
    U(q) = 1/2 sum_g w_g eps_g^T D eps_g + 1/2 q^T K_l q

The internal force is a cubic polynomial of q, so every derivative below is exact. The functions work on all
elements of a block at once and accept complex q (for complex-step differentiation).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class QuadraticStrain:
    """The strain arrays of E elements of one kind; read-only.

    Parameters
    ----------
    dofs : int array (E, n)             nodal freedoms of each element, node by node
    B : float array (E, g, s, n)        linear strain
    G : float array (E, g, d, n)        displacement gradients that make the strain nonlinear
    N : float array (s, d, d)           quadratic form, symmetric in its last two indices
    D : float array (s, s) or (E, s, s)     constitutive matrix
    w : float array (E, g)              weights: quadrature weight times Jacobian
    linear_stiffness : float array (E, n, n) or None
        K_l, energy that stays quadratic (a shell's bending and drilling)
    """

    dofs: NDArray[np.int64]
    B: FloatArray
    G: FloatArray
    N: FloatArray
    D: FloatArray
    w: FloatArray
    linear_stiffness: FloatArray | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            array = getattr(self, field.name)
            if array is not None:
                array.setflags(write=False)

    def of(self, elements: slice | NDArray[np.int64]) -> QuadraticStrain:
        """The same arrays for some of the elements."""
        own = {
            name: getattr(self, name)[elements]
            for name in ("dofs", "B", "G", "w", "linear_stiffness")
            if getattr(self, name) is not None
        }
        return replace(self, **own, D=self.D[elements] if self.D.ndim == 3 else self.D)

    @property
    def weighted_D(self) -> FloatArray:
        """w_g D, (E, g, s, s)."""
        D = self.D if self.D.ndim == 3 else self.D[None]
        return self.w[:, :, None, None] * D[:, None]


def strain(block: QuadraticStrain, q: Array) -> Array:
    """Strains eps (E, g, s) from element freedoms q (E, n)."""
    a = _apply(block.G, q)
    return _apply(block.B, q) + 0.5 * _apply(_contract(block.N, a), a)


def energy(block: QuadraticStrain, q: Array) -> Array:
    """Strain energy U (E,) of each element."""
    return energies(block, q[..., None])[..., 0]


def energies(block: QuadraticStrain, Q: Array) -> Array:
    """Strain energies U (E, t) of each element, for t sets of element freedoms Q (E, n, t)."""
    a = _directions(block.G, Q)
    # N(a, a) with the sets before the strains, so that each is one small matrix product.
    Na = np.tensordot(a, block.N, axes=(2, 1))
    quadratic = (Na @ a.swapaxes(2, 3)[..., None])[..., 0].swapaxes(2, 3)
    eps = _directions(block.B, Q) + 0.5 * quadratic
    U = 0.5 * (eps * (block.weighted_D @ eps)).sum(axis=(1, 2))
    if block.linear_stiffness is not None:
        U = U + 0.5 * (Q * (block.linear_stiffness @ Q)).sum(axis=1)
    return U


def internal_force(block: QuadraticStrain, q: Array) -> Array:
    """Internal force dU/dq (E, n): sum_g w [B + N(Gq)G]^T D eps."""
    a = _apply(block.G, q)
    Na = _contract(block.N, a)
    D = block.D if block.D.ndim == 2 else block.D[:, None]
    stress = block.w[..., None] * _apply(D, _apply(block.B, q) + 0.5 * _apply(Na, a))
    f = _gather(block.B, stress) + _gather(block.G, _gather_points(Na, stress))
    if block.linear_stiffness is not None:
        f = f + _times(block.linear_stiffness, q)
    return f


def strain_rate_force(block: QuadraticStrain, q: Array, rates: Array) -> Array:
    """Force (E, n) of stresses D eps_dot: K_mat(q) q_dot = sum_g w A^T D A q_dot + K_l q_dot, A = B + N(Gq)G.

    Kelvin and Voigt's damping is this times a time. A rigid motion has no strain rate, hence no force.
    """
    Na = _contract(block.N, _apply(block.G, q))
    strain_rate = _apply(block.B, rates) + _apply(Na, _apply(block.G, rates))
    stress = _apply(block.weighted_D, strain_rate)
    f = _gather(block.B, stress) + _gather(block.G, _gather_points(Na, stress))
    if block.linear_stiffness is not None:
        f = f + _times(block.linear_stiffness, rates)
    return f


def tangent(block: QuadraticStrain, q: Array, *, material: float = 1.0) -> Array:
    """Tangent stiffness dF/dq (E, n, n): sum_g w { A^T D A + G^T N^T(sigma) G } + K_l, A = B + N(Gq)G.

    material : a factor of all but the geometric term, as damping by strain rate adds to the rest
    """
    a = _apply(block.G, q)
    Na = _contract(block.N, a)
    weighted_D = block.weighted_D
    A = block.B + Na @ block.G
    stress = _apply(weighted_D, _apply(block.B, q) + 0.5 * _apply(Na, a))
    K = _congruence(A, weighted_D @ A)
    if block.linear_stiffness is not None:
        K = K + block.linear_stiffness
    return material * K + _congruence(block.G, _stress_form(block.N, stress) @ block.G)


def stiffness(block: QuadraticStrain) -> FloatArray:
    """Linear stiffness (E, n, n): the tangent at q = 0."""
    K = _congruence(block.B, block.weighted_D @ block.B)
    return K if block.linear_stiffness is None else K + block.linear_stiffness


def tangent_derivative(block: QuadraticStrain, x: Array) -> Array:
    """Derivative of the tangent at q = 0 in the direction x (E, n); (E, n, n), symmetric.

    sum_g w { B^T D N(Gx)G + [N(Gx)G]^T D B + G^T N^T(D B x) G }
    """
    weighted_D = block.weighted_D
    A1 = _contract(block.N, _apply(block.G, x)) @ block.G
    stress = _apply(weighted_D, _apply(block.B, x))
    half = _congruence(block.B, weighted_D @ A1)
    return half + half.swapaxes(1, 2) + _congruence(block.G, _stress_form(block.N, stress) @ block.G)


def pair_forces(block: QuadraticStrain, X: FloatArray) -> FloatArray:
    """Second derivative of the internal force at q = 0 along all pairs of directions.

        f''(x, y) = sum_g w { B^T D N(Gx, Gy) + G^T N^T(D B x) G y + G^T N^T(D B y) G x }

    Parameters
    ----------
    X : float array (E, n, m)       m directions
    Returns
    -------
    float array (E, n, m(m+1)/2)    pairs j <= k in the order of numpy.triu_indices(m)
    """
    n_elements, n_points, d, _ = block.G.shape
    s, m = block.N.shape[0], X.shape[2]
    j, k = np.triu_indices(m)
    a = _directions(block.G, X)
    stress = block.weighted_D @ _directions(block.B, X)
    # N(a_j) as rows (s, j) by gradient columns, so that all pairs are one small matrix product a point.
    Na = np.tensordot(a, block.N, axes=(2, 1)).transpose(0, 1, 3, 2, 4)
    second_strain = (Na.reshape(n_elements, n_points, s * m, d) @ a).reshape(n_elements, n_points, s, m, m)
    second_stress = block.weighted_D @ second_strain[..., j, k]
    gradient_force = (Na.transpose(0, 1, 4, 3, 2).reshape(n_elements, n_points, d * m, s) @ stress).reshape(
        n_elements, n_points, d, m, m
    )
    gradient_force = gradient_force[..., j, k] + gradient_force[..., k, j]
    return _gather_directions(block.B, second_stress) + _gather_directions(block.G, gradient_force)


def _apply(operator: Array, vector: Array) -> Array:
    """(E, g, a, b) on (E, b) or (E, g, b) -> (E, g, a)."""
    if vector.ndim == 2:
        vector = vector[:, None]
    return (operator @ vector[..., None])[..., 0]


def _times(matrix: Array, vector: Array) -> Array:
    """(E, a, b) on (E, b) -> (E, a)."""
    return (matrix @ vector[..., None])[..., 0]


def _contract(form: FloatArray, a: Array) -> Array:
    """N(a, .) as matrices (E, g, s, d) from a (E, g, d)."""
    return np.tensordot(a, form, axes=(2, 1))


def _stress_form(form: FloatArray, stress: Array) -> Array:
    """N^T(sigma) = sum_s sigma_s N_s, (E, g, d, d)."""
    return np.tensordot(stress, form, axes=(2, 0))


def _gather(operator: Array, values: Array) -> Array:
    """Transpose of `operator` on point values, summed over points: (E, g, a, n), (E, g, a) -> (E, n)."""
    return (_over_points(operator).swapaxes(1, 2) @ values.reshape(len(values), -1, 1))[..., 0]


def _gather_points(operator: Array, values: Array) -> Array:
    """Transpose of `operator` on point values: (E, g, a, b), (E, g, a) -> (E, g, b)."""
    return (operator.swapaxes(2, 3) @ values[..., None])[..., 0]


def _congruence(left: Array, right: Array) -> Array:
    """sum_g left^T right, (E, n, n)."""
    return _over_points(left).swapaxes(1, 2) @ _over_points(right)


def _directions(operator: FloatArray, X: FloatArray) -> FloatArray:
    """(E, g, a, n) on (E, n, m) -> (E, g, a, m)."""
    return (_over_points(operator) @ X).reshape(*operator.shape[:3], -1)


def _gather_directions(operator: FloatArray, values: FloatArray) -> FloatArray:
    """(E, g, a, n), (E, g, a, p) -> (E, n, p)."""
    return _over_points(operator).swapaxes(1, 2) @ _over_points(values)


def _over_points(array: Array) -> Array:
    """Points and rows as one axis: (E, g, a, n) -> (E, g a, n)."""
    return array.reshape(len(array), -1, array.shape[-1])
