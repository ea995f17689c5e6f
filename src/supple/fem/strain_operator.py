"""The strains of a whole body by a few sparse products, for repeated forces in time integration.

With the linear strains and the displacement gradients of all points as one sparse matrix, `[b, a] = L q`,

    eps = b + P p(a),   p_k = a_i a_j       sigma = w D (eps + tau eps_dot)
    F = L^T [sigma, (dp/da)^T P^T sigma]

where `P` has the coefficients of the quadratic form. Evaluated element by element, the same sum takes
three to four times as long, as it reads the strain arrays several times, zeros included.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csc_array, csr_array

from supple.arrays import FloatArray
from supple.fem.assembly import Assembly
from supple.fem.quadratic_strain import QuadraticStrain


class _Part(NamedTuple):
    """One block of elements; in shapes, P = E g is the number of points, the last axis of point arrays."""

    block: QuadraticStrain
    linear: csr_array
    """`L`, ((s + d) P, n)"""
    gather: csc_array
    """`L^T`, with the arrays of `L`; stored, as transposing takes as long as a product for a small body"""
    first: NDArray[np.intp]
    second: NDArray[np.intp]
    """`i` and `j` of the products, (k,)"""
    products: csr_array | FloatArray
    """Coefficients of the quadratic form: one sparse matrix (s, k), or a matrix per point, (P, s, k)"""
    sums: tuple[csr_array, csr_array]
    """Selection of the products by their first and their second gradient, (d, k)"""

    def split(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Linear strains (s, P) and gradients (d, P)."""
        _, _, n_strains, _ = self.block.B.shape
        joined = (self.linear @ q).reshape(n_strains + self.block.G.shape[2], -1)
        return joined[:n_strains], joined[n_strains:]

    def by_products(self, products: FloatArray) -> FloatArray:
        """Strains (s, P) from products (k, P)."""
        if isinstance(self.products, csr_array):
            return self.products @ products
        return np.einsum("psk,kp->sp", self.products, products)

    def on_products(self, stress: FloatArray) -> FloatArray:
        """The transpose of `by_products`: (k, P) from stresses (s, P)."""
        if isinstance(self.products, csr_array):
            return self.products.T @ stress
        return np.einsum("psk,sp->kp", self.products, stress)

    def stress(self, strain: FloatArray) -> FloatArray:
        """`w D strain` with the enhanced strains, (s, P)."""
        D, w = self.block.D, self.block.w
        if self.block.enhanced is not None:
            by_point = strain.T.reshape(*w.shape, -1, 1)
            strain = self.block.with_enhanced(by_point).reshape(w.size, -1).T
        if D.ndim == 2:
            return w.ravel() * (D @ strain)
        by_element = strain.T.reshape(*w.shape, -1) @ D.swapaxes(1, 2)
        return w.ravel() * by_element.reshape(w.size, -1).T


@dataclass(frozen=True, eq=False)
class StrainOperator:
    """The strains of a body as sparse products, built by `strain_operator`."""

    parts: tuple[_Part, ...]

    def force(self, q: FloatArray, rates: FloatArray, retardation_time: float) -> FloatArray:
        """Force (n,) of the stresses `D (eps + tau eps_dot)`, elastic and of Kelvin-Voigt damping.

        q, rates : (n,); retardation_time : tau, s, 0 for none
        """
        return np.sum([self._force(part, q, rates, retardation_time) for part in self.parts], axis=0)

    @staticmethod
    def _force(part: _Part, q: FloatArray, rates: FloatArray, time: float) -> FloatArray:
        i, j = part.first, part.second
        strain, a = part.split(q)
        at_i, at_j = a[i], a[j]
        products = at_i * at_j
        if time:
            strain_rate, a_rate = part.split(rates)
            strain = strain + time * strain_rate
            products += time * (a_rate[i] * at_j)
            products += time * (a_rate[j] * at_i)
        stress = part.stress(strain + part.by_products(products))
        weights = part.on_products(stress)
        at_first, at_second = part.sums
        on_gradients = at_first @ (weights * at_j) + at_second @ (weights * at_i)
        return part.gather @ np.concatenate([stress, on_gradients]).ravel()


def strain_operator(assembly: Assembly) -> StrainOperator:
    """The strains of an assembly as sparse products of its freedoms."""
    pairs = zip(assembly.blocks, assembly.gathers, strict=True)
    return StrainOperator(tuple(_part(block, gather) for block, gather in pairs))


def _part(block: QuadraticStrain, gather: csr_array) -> _Part:
    n_elements, n_points, _, n = block.B.shape
    rows = np.concatenate([block.B, block.G], axis=2)
    places = np.arange(n_elements + 1)
    joined = rows.reshape(n_elements, -1, n)
    by_element = csr_array(bsr_array((joined, places[:-1], places)))
    by_element.eliminate_zeros()
    n_rows = n_points * rows.shape[2]
    order = np.arange(n_elements * n_rows).reshape(n_elements * n_points, -1).T.ravel()
    i, j = np.nonzero(np.triu(block.N.any(axis=tuple(range(block.N.ndim - 2)))))
    products = block.N[..., i, j] * np.where(i == j, 0.5, 1.0)
    # On long rows a sparse matrix with so few entries is several times faster than a dense one.
    products = csr_array(products) if products.ndim == 2 else products.reshape(-1, *products.shape[2:])
    n_gradients, each = block.G.shape[2], np.arange(len(i))
    first, second = (csr_array((np.ones(len(i)), (at, each)), shape=(n_gradients, len(i))) for at in (i, j))
    linear = csr_array(by_element[order] @ gather)
    return _Part(block, linear, linear.T, i, j, products, (first, second))
