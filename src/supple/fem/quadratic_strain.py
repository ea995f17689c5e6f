"""Quadratic strain: the common form of all elements, with energy, force, tangent and their derivatives.

At integration point g of an element with freedoms q (total Lagrangian, undeformed reference):

    eps_g(q) = B_g q + 1/2 N(G_g q, G_g q)
    U(q) = 1/2 sum_g w_g eps_g^T D eps_g

or, with k strains R of the element's own (`enhanced`), of which those of least energy are added,

    U(q) = min_c 1/2 sum_g w_g (eps_g + R_g c)^T D (eps_g + R_g c),      sum_g w_g R_g^T D R_g = 1.

The internal force is a cubic polynomial of q, so every derivative below is exact. The functions work on all
elements of a block at once and accept complex q (for complex-step differentiation).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray

__all__ = ["QuadraticStrain"]

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class QuadraticStrain:
    """The strain arrays of E elements of one kind; read-only.

    dofs : (E, n)    nodal freedoms of each element, node by node
    B : (E, g, s, n)    linear strain
    G : (E, g, d, n)    displacement gradients of the quadratic strain
    N : (s, d, d) or (E, g, s, d, d)    quadratic form, symmetric in its last two indices
    D : (s, s) or (E, s, s)    constitutive matrix
    w : (E, g)    weights: quadrature weight times Jacobian
    enhanced : (E, g, s, k) or None    strains R, orthonormal in energy; None for no such strains
    """

    dofs: NDArray[np.int64]
    B: FloatArray
    G: FloatArray
    N: FloatArray
    D: FloatArray
    w: FloatArray
    enhanced: FloatArray | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            if getattr(self, field.name) is not None:
                getattr(self, field.name).setflags(write=False)

    def of(self, elements: slice | NDArray[np.int64]) -> QuadraticStrain:
        """The same arrays for some of the elements."""
        names = ["dofs", "B", "G", "w"]
        names += ["D"] * (self.D.ndim == 3) + ["N"] * (self.N.ndim == 5)
        names += ["enhanced"] * (self.enhanced is not None)
        return replace(self, **{name: getattr(self, name)[elements] for name in names})

    @property
    def weighted_D(self) -> FloatArray:
        """w_g D, (E, g, s, s)."""
        D = self.D if self.D.ndim == 3 else self.D[None]
        return self.w[:, :, None, None] * D[:, None]

    @cached_property
    def enhanced_stress(self) -> FloatArray:
        """w_g D R of the enhanced strains, (E, g s, k); for blocks with such strains only."""
        assert self.enhanced is not None
        return _over_points(self.weighted_D @ self.enhanced)

    def with_enhanced(self, eps: Array) -> Array:
        """Strains eps - R sum_g w R^T D eps (E, g, s, m) with the enhanced strains of least energy."""
        if self.enhanced is None:
            return eps
        R, flat = _over_points(self.enhanced), _over_points(eps)
        return (flat - R @ (self.enhanced_stress.swapaxes(1, 2) @ flat)).reshape(eps.shape)

    def weighted_stress(self, eps: Array) -> Array:
        """w_g D of the strains `with_enhanced`, (E, g, s, m)."""
        return self.weighted_D @ self.with_enhanced(eps)


def strain(block: QuadraticStrain, q: Array) -> Array:
    """Strains eps (E, g, s) from element freedoms q (E, n)."""
    a = _apply(block.G, q)
    return _strain(block, q, _contract(block.N, a), a)


def strains(block: QuadraticStrain, Q: Array) -> Array:
    """Strains (E, g, s, t) of t sets of element freedoms Q (E, n, t)."""
    return block.with_enhanced(_directions(block.B, Q) + _half_square(block.N, _directions(block.G, Q)))


def energy(block: QuadraticStrain, q: Array) -> Array:
    """Strain energy U (E,) of each element."""
    return energies(block, q[..., None])[..., 0]


def energies(block: QuadraticStrain, Q: Array) -> Array:
    """Strain energies U (E, t) of each element, for t sets of element freedoms Q (E, n, t)."""
    eps = strains(block, Q)
    return 0.5 * (eps * (block.weighted_D @ eps)).sum(axis=(1, 2))


def internal_force(block: QuadraticStrain, q: Array) -> Array:
    """Internal force dU/dq (E, n): sum_g w [B + N(Gq)G]^T D eps."""
    a = _apply(block.G, q)
    Na = _contract(block.N, a)
    D = block.D if block.D.ndim == 2 else block.D[:, None]
    stress = block.w[..., None] * _apply(D, _strain(block, q, Na, a))
    return _gather(block.B, stress) + _gather(block.G, _gather_points(Na, stress))


def internal_forces(block: QuadraticStrain, Q: FloatArray, stretching: FloatArray) -> FloatArray:
    """Internal forces (E, n, t) at t sets of element freedoms Q (E, n, t).

        f = sum_g w A^T D [B (q + z) + 1/2 N(Gq, Gq)],   A = B + N(Gq)G

    stretching : z (E, n, t)    displacement of which only the linear strain B z acts, as a condensed motion
    """
    a = _directions(block.G, Q)
    stress = block.weighted_stress(_directions(block.B, Q + stretching) + _half_square(block.N, a))
    form = "sde" if block.N.ndim == 3 else "Egsde"
    turned = np.einsum(f"Egst,{form},Eget->Egdt", stress, block.N, a, optimize=True)
    return _gather_directions(block.B, stress) + _gather_directions(block.G, turned)


def strain_rate_force(block: QuadraticStrain, q: Array, rates: Array) -> Array:
    """Force (E, n) of stresses D eps_dot: K_mat(q) q_dot = sum_g w A^T D A q_dot, A = B + N(Gq)G.

    Kelvin-Voigt damping is this force times a retardation time. A rigid motion has no strain rate and no
    force.
    """
    Na = _contract(block.N, _apply(block.G, q))
    strain_rate = _apply(block.B, rates) + _apply(Na, _apply(block.G, rates))
    stress = block.weighted_stress(strain_rate[..., None])[..., 0]
    return _gather(block.B, stress) + _gather(block.G, _gather_points(Na, stress))


def strain_rate_tangent(block: QuadraticStrain, q: Array, rates: Array) -> Array:
    """Derivative (E, n, n) of `strain_rate_force` with respect to q, at constant rates; not symmetric.

    sum_g w { A^T D N(G q_dot)G + G^T N^T(D eps_dot) G },   A = B + N(Gq)G
    """
    Na = _contract(block.N, _apply(block.G, q))
    A = block.B + Na @ block.G
    A_rate = _contract(block.N, _apply(block.G, rates)) @ block.G
    stress = block.weighted_stress(_apply(A, rates)[..., None])[..., 0]
    turned = _congruence(block.G, _stress_form(block.N, stress) @ block.G)
    return _congruence(A, block.weighted_stress(A_rate)) + turned


def tangent(block: QuadraticStrain, q: Array, *, material: float = 1.0) -> Array:
    """Tangent stiffness dF/dq (E, n, n): sum_g w { A^T D A + G^T N^T(sigma) G }, A = B + N(Gq)G.

    material : factor on the material term (strain-rate damping is proportional to this term)
    """
    parts = tangent_parts(block, q)
    return material * parts[:, 0] + parts[:, 1]


def tangent_parts(block: QuadraticStrain, q: Array) -> Array:
    """The material and the geometric term of the tangent, (E, 2, n, n)."""
    a = _apply(block.G, q)
    Na = _contract(block.N, a)
    A = block.B + Na @ block.G
    stress = _apply(block.weighted_D, _strain(block, q, Na, a))
    material = _congruence(A, block.weighted_stress(A))
    return np.stack([material, _congruence(block.G, _stress_form(block.N, stress) @ block.G)], axis=1)


def stiffness(block: QuadraticStrain) -> FloatArray:
    """Linear stiffness (E, n, n): the tangent at q = 0."""
    return _congruence(block.B, block.weighted_stress(block.B))


def tangent_derivative(block: QuadraticStrain, x: Array) -> Array:
    """Derivative of the tangent at q = 0 in the direction x (E, n); (E, n, n), symmetric.

    sum_g w { B^T D N(Gx)G + [N(Gx)G]^T D B + G^T N^T(D B x) G }
    """
    A1 = _contract(block.N, _apply(block.G, x)) @ block.G
    stress = block.weighted_stress(_apply(block.B, x)[..., None])[..., 0]
    half = _congruence(block.B, block.weighted_stress(A1))
    return half + half.swapaxes(1, 2) + _congruence(block.G, _stress_form(block.N, stress) @ block.G)


def pair_forces(block: QuadraticStrain, X: FloatArray) -> FloatArray:
    """Second derivative of the internal force at q = 0 along all pairs of directions.

        f''(x, y) = sum_g w { B^T D N(Gx, Gy) + G^T N^T(D B x) G y + G^T N^T(D B y) G x }

    X : (E, n, m)    m directions
    Returns (E, n, m(m+1)/2): pairs j <= k in the order of numpy.triu_indices(m).
    """
    m = X.shape[2]
    a = _directions(block.G, X)
    stress = block.weighted_stress(_directions(block.B, X))
    stiff_B = block.weighted_stress(block.B)
    forces = np.empty((*block.dofs.shape, m * (m + 1) // 2))
    # One direction and all later ones at a time: the arrays of all pairs at once would be large.
    start = 0
    for j in range(m):
        pairs = slice(start, start + m - j)
        Na = _contract(block.N, a[..., j])
        gradient_force = _stress_form(block.N, stress[..., j]) @ a[..., j:]
        gradient_force += Na.swapaxes(2, 3) @ stress[..., j:]
        second = _gather_directions(block.G, gradient_force)
        forces[..., pairs] = second + _gather_directions(stiff_B, Na @ a[..., j:])
        start = pairs.stop
    return forces


def force_parts(block: QuadraticStrain, X: FloatArray) -> Iterator[FloatArray]:
    """Yield the terms of the internal force for m directions, one array each; p counts the pairs j <= k.

        sum_g w B^T D N(G x_j, G x_k)                       (E, n, p)   once
        sum_g w G^T N(G x_j)^T D B x_k                      (E, n, m)   for every j
        sum_g w G^T N(G x_i)^T D N(G x_j, G x_k)            (E, n, p)   for every i

    X : (E, n, m)    directions; pairs in the order of numpy.triu_indices(m)
    """
    m = X.shape[2]
    a = _directions(block.G, X)
    stress = block.weighted_stress(_directions(block.B, X))
    second_strain = np.concatenate([_contract(block.N, a[..., j]) @ a[..., j:] for j in range(m)], axis=-1)
    yield _gather_directions(block.weighted_stress(block.B), second_strain)
    turned = [_contract(block.N, a[..., j]) @ block.G for j in range(m)]
    yield from (_gather_directions(each, stress) for each in turned)
    second_stress = block.weighted_stress(second_strain)
    yield from (_gather_directions(each, second_stress) for each in turned)


def strain_pair_forces(
    block: QuadraticStrain, X: FloatArray, first: NDArray[np.integer], second: NDArray[np.integer]
) -> FloatArray:
    """Forces of the quadratic strain of selected pairs of directions, in the undeformed geometry.

        f_p = sum_g w B^T D N(G x_first(p), G x_second(p))

    This is the first of the three terms of `pair_forces`: the force of the stress D N(x, y). The other two
    terms, of the linear stresses of x and of y, are not included.

    X : (E, n, m)    m directions
    first, second : int arrays (p,)    columns of X
    Returns (E, n, p).
    """
    a = _directions(block.G, X)
    stiff_B = block.weighted_stress(block.B)
    forces = np.empty((*block.dofs.shape, len(first)))
    # One direction and all directions paired with it at a time: the arrays of all pairs would be large.
    for j in np.unique(first):
        pairs = np.flatnonzero(first == j)
        second_strain = _contract(block.N, a[..., j]) @ a[..., second[pairs]]
        forces[..., pairs] = _gather_directions(stiff_B, second_strain)
    return forces


def _strain(block: QuadraticStrain, q: Array, Na: Array, a: Array) -> Array:
    """Strains (E, g, s) from q (E, n), a = G q and N(a, .)."""
    eps = _apply(block.B, q) + 0.5 * _apply(Na, a)
    return block.with_enhanced(eps[..., None])[..., 0]


def _apply(operator: Array, vector: Array) -> Array:
    """(E, g, a, b) on (E, b) or (E, g, b) -> (E, g, a)."""
    if vector.ndim == 2:
        vector = vector[:, None]
    return (operator @ vector[..., None])[..., 0]


def _contract(form: FloatArray, a: Array) -> Array:
    """N(a, .) as matrices (E, g, .., s, d) from a (E, g, .., d)."""
    if form.ndim == 3:
        return np.tensordot(a, form, axes=(a.ndim - 1, 1))
    n_strains, d, _ = form.shape[2:]
    rows = form.reshape(*form.shape[:2], n_strains * d, d)
    return (a.reshape(*a.shape[:2], -1, d) @ rows.swapaxes(2, 3)).reshape(*a.shape[:-1], n_strains, d)


def _half_square(form: FloatArray, a: Array) -> Array:
    """1/2 N(a, a), (E, g, s, t), from a (E, g, d, t): only the nonzero products of the form are evaluated."""
    i, j = np.nonzero(np.triu(form.any(axis=tuple(range(form.ndim - 2)))))
    coefficients = form[..., i, j] * np.where(i == j, 0.5, 1.0)
    return coefficients @ (a[:, :, i] * a[:, :, j])


def _stress_form(form: FloatArray, stress: Array) -> Array:
    """N^T(sigma) = sum_s sigma_s N_s, (E, g, d, d)."""
    if form.ndim == 3:
        return np.tensordot(stress, form, axes=(2, 0))
    d = form.shape[-1]
    flat = form.reshape(*form.shape[:3], d * d)
    return (stress[:, :, None] @ flat).reshape(*form.shape[:2], d, d)


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
