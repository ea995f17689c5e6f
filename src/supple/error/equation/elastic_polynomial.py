"""Elasticity of a body in few columns, as one polynomial for every run in these columns.

With about a hundred columns the polynomial of the tangent does not fit in memory; `elastic_history` then uses
sample times of one run. With the thirty columns of an indicator the polynomial fits, and one pass over the
elements serves any number of runs. With g the coordinates of a run in the first s columns, the force and the
tangent exceed those of the stiffness at rest by

    f_a       = (L_ajl / 2 + T_ajl) g_j g_l + C_iajl g_i g_j g_l / 2
    df_a/dg_b = (L_abl + T_abl + T_alb) g_l + (C_bajl / 2 + C_jabl) g_j g_l

with L, T, C the works `linear`, `turned`, `cubic` of the columns on themselves. The force of damping by
strain rate is v_a = (L_ajk + T_ajk) g_j g'_k + C_iajk g_i g_j g'_k.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from supple.arrays import FloatArray
from supple.error.equation.elastic_history import force_polynomial, strain_rate_polynomial
from supple.fem import StrainWorks
from supple.reduction.tensors import StrainProducts, unpack_symmetric


def works_on_themselves(products: StrainProducts) -> StrainWorks:
    """The strain works of k columns on themselves, from the inner products of their strains.

        L_ajl = F_a,jl    T_ajl = F_l,aj    C_iajl = H_ia,jl

    The products are symmetric matrices, so that they take a fifth of the time of `Assembly.works`.
    """
    linear, cubic = products.strain_by_pair, products.pair_by_pair
    assert linear is not None
    assert cubic is not None
    k = len(linear)
    turned = np.moveaxis(unpack_symmetric(linear, k), 0, 2)
    return StrainWorks(linear, turned, np.moveaxis(unpack_symmetric(cubic.T, k), 0, 2))


@dataclass(frozen=True, eq=False)
class ElasticPolynomial:
    """Force, tangent and damping added by a deformation `X g`, in k columns Z; X are the first s of them.

    works : strain works of Z on itself (`Assembly.works`)
    n_motion : number s of columns X
    """

    works: StrainWorks
    n_motion: int

    @cached_property
    def _of_motion(self) -> StrainWorks:
        """Strain works of X on Z."""
        s, k = self.n_motion, self.works.turned.shape[2]
        first, second = np.triu_indices(k)
        kept = (first < s) & (second < s)
        return StrainWorks(
            self.works.linear[:, kept], self.works.turned[:, :s, :s], self.works.cubic[:s][..., kept]
        )

    def force(self, coordinates: FloatArray) -> FloatArray:
        """Forces (t, k) beyond the stiffness at rest, at coordinates (t, s)."""
        return force_polynomial(self._of_motion)(coordinates)

    def strain_rate_force(self, coordinates: FloatArray, rates: FloatArray) -> FloatArray:
        """Forces (t, k) of the strain rates beyond those at rest, per unit of retardation time."""
        return strain_rate_polynomial(self._of_motion)(coordinates, rates)

    @cached_property
    def tangents(self) -> tuple[FloatArray, FloatArray]:
        """Tangents per monomial of `monomials`, and their material parts, (m, k, k) each."""
        linear, turned, cubic = self._symmetric
        first, second = np.triu_indices(self.n_motion)
        s, k = self.n_motion, linear.shape[0]
        own = np.where(first == second, 0.5, 1.0)[:, None, None]
        of_first, of_second = cubic[first], cubic[second]  # (p, a, j, l)
        pairs = np.arange(len(first))
        # (p, a, b): C_jabl and C_labj.
        crossed = of_first[pairs, :, :, second] + of_second[pairs, :, :, first]
        geometric = np.moveaxis(cubic[:, :, first, second], 2, 0).swapaxes(1, 2)  # C_bajl
        whole = np.concatenate(
            [
                np.moveaxis((linear + turned + turned.swapaxes(1, 2))[:, :, :s], 2, 0),
                own * (geometric + crossed),
            ]
        )
        material = np.concatenate([np.moveaxis(self._bilinear[:, :s], 1, 0), own * crossed])
        assert whole.shape == material.shape == (s + len(first), k, k)
        return whole, material

    @cached_property
    def rate_tangents(self) -> FloatArray:
        """Tangents per monomial of `rate_monomials`, per unit of retardation time, (s + s^2, k, k)."""
        _, _, cubic = self._symmetric
        s, k = self.n_motion, cubic.shape[0]
        own = np.moveaxis(self._bilinear[:, :, :s], 2, 0)
        # C_bajk + C_jabk, for each pair (j, k).
        products = cubic[:, :, :s, :s].transpose(2, 3, 1, 0) + cubic[:s][..., :s].transpose(0, 3, 1, 2)
        return np.concatenate([own, products.reshape(s * s, k, k)])

    @cached_property
    def _symmetric(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Linear (k, k, k), turned, and cubic (i, k, k, k) works, with both orders of each pair."""
        k = self.works.turned.shape[2]
        first, second = np.triu_indices(k)

        def both(packed: FloatArray) -> FloatArray:
            full = np.empty((*packed.shape[:-1], k, k))
            full[..., first, second] = full[..., second, first] = packed
            return full

        return both(self.works.linear), self.works.turned, both(self.works.cubic)

    @cached_property
    def _bilinear(self) -> FloatArray:
        """Bilinear coefficients B (k, k, k)."""
        linear, turned, _ = self._symmetric
        return linear + turned
