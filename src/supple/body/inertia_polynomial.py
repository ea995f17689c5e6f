"""Kinetic energy of a body in a floating frame: a polynomial of degree two in its coordinates and rates.

Nodes and rigid interfaces move by `u` and rotate by the rotation vector `theta` relative to the frame, whose
angular velocity is `w`. The angular velocity of a node with the inertia J in its own axes is
`exp(-theta~) w + (I - theta~/2 + ..) theta'`, so that

    w_n = w + (w x theta + theta') + 1/2 theta x (theta x w) - 1/2 theta x theta'
    T_J = 1/2 w J w + w J (w x theta + theta') + 1/2 (w x theta + theta') J (w x theta + theta')
          + 1/2 w J (theta x (theta x w) - theta x theta')                           + O(|theta|^3)

Terms of third order in theta are omitted; `w x theta` represents the gyroscopic moment. A mass that couples
the rotations of two nodes (consistent or condensed) is a bilinear form of the theta of both nodes. A mass
that couples translations to rotations is that of a point beside its node, with displacement u + theta x c.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csc_array, csr_array, vstack

from supple.algebra.cross import cross_matrices, cross_matrix

if TYPE_CHECKING:
    from supple.body.flexible_body import FlexibleBody

SPIN_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Pairs (i, j) of angular velocity components, in the order of `by_spin`."""

_AXES = np.eye(3)
_CROSS = np.array([cross_matrix(axis) for axis in _AXES])
_TWICE = np.einsum("ica,jcb->ijab", _CROSS, _CROSS)
"""`(e_i x a) . (e_j x b)`"""
_ROUNDING = 1e-14
"""Deviation of a mass block from m I, relative to the largest mass entry, up to which it counts as m I."""


@dataclass(frozen=True, eq=False)
class InertiaPolynomial:
    """Coefficients of the kinetic energy, in the body's coordinates, with the frame's origin at rest.

        T = 1/2 q' M q' + w_i (P_i . q' + q B_i q') + 1/2 w_i w_j (J_ij + 2 k_ij . q + q Z_ij q)

    where `P_i` are the columns of M R for rotations. All coefficients follow from the 3 x 3 blocks of the
    mass matrix. Blocks m I between two translations (point masses) have B_i = - m e_i x and
    Z_ij = - m e_i x e_j x; one product with these blocks of M gives the products with all B_i and Z_ij.
    """

    body: FlexibleBody

    @property
    def _rest(self) -> csc_array | None:
        """Map from the body's coordinates to those in triples; None where they are equal."""
        return None if self.body.threes is None else self.body.threes[0]

    @property
    def _mass(self) -> csc_array:
        return self.body.mass if self.body.threes is None else self.body.threes[1]

    @property
    def _rigid_modes(self) -> NDArray[np.float64]:
        return self.body.rigid_modes if self._rest is None else self._rest @ self.body.rigid_modes

    def _reduced(self, matrix: csr_array) -> csr_array:
        """A matrix for coordinates in triples, transformed to those of the body."""
        return matrix if self._rest is None else csr_array(self._rest.T @ matrix @ self._rest)

    def _gathered(self, fields: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
        """Forces in triples along `axis`, transformed to forces in the body's coordinates along this axis."""
        if self._rest is None:
            return fields
        ahead = np.moveaxis(fields, axis, 0)
        gathered = self._rest.T @ ahead.reshape(len(ahead), -1)
        return np.moveaxis(gathered.reshape(len(gathered), *ahead.shape[1:]), 0, axis)

    @cached_property
    def _blocks(self) -> _Blocks:
        mass = bsr_array(self._mass.tocsr(), blocksize=(3, 3))
        turns = ~np.any(self._rigid_modes.reshape(-1, 3, 6)[:, :, :3], axis=(1, 2))
        row, column = np.repeat(turns, np.diff(mass.indptr)), turns[mass.indices]
        off = abs(mass.data - mass.data[:, :1, :1] * _AXES).max(axis=(1, 2), initial=0.0)
        alike = off <= _ROUNDING * abs(mass.data).max(initial=0.0)
        return _Blocks(mass, turns, ~row & column, row & ~column, row & column, ~row & ~column & alike)

    @cached_property
    def _points(self) -> csr_array:
        """Blocks m I between two translations, (n, n)."""
        return self._blocks.matrix(self._blocks.mass.data, self._blocks.points)

    @cached_property
    def by_rate(self) -> tuple[csr_array, ...]:
        """`B_i`, 3 of (n, n)."""
        return tuple(self._reduced(self._blocks.matrix(self._rate_blocks(i))) for i in range(3))

    @cached_property
    def by_spin(self) -> tuple[csr_array, ...]:
        """`Z_ij` of `SPIN_PAIRS`, 6 of (n, n); Z_ji is the transpose of Z_ij."""
        every = np.ones_like(self._blocks.points)
        return tuple(self._reduced(self._by_spin(i, j, every)) for i, j in SPIN_PAIRS)

    @cached_property
    def _rates_beside_points(self) -> tuple[csr_array, csr_array] | None:
        """`B_i^T` and `B_i` of all blocks except point masses, (3 n, n) each; None without such blocks."""
        beside = ~self._blocks.points
        if not beside.any():
            return None
        each = [self._blocks.matrix(self._rate_blocks(i), beside) for i in range(3)]
        return _stacked([matrix.T for matrix in each]), _stacked(each)

    @cached_property
    def _spins_beside_points(self) -> csr_array | None:
        """`Z_ij` of all blocks except point masses, (9 n, n); None without such blocks."""
        beside = ~self._blocks.points
        if not beside.any():
            return None
        each = {(i, j): self._by_spin(i, j, beside) for i, j in SPIN_PAIRS}
        return _stacked([each[i, j] if i <= j else each[j, i].T for i in range(3) for j in range(3)])

    def _rate_blocks(self, i: int) -> NDArray[np.float64]:
        blocks, mass = self._blocks, self._blocks.mass.data
        data = -_CROSS[i] @ mass
        data[blocks.of_rotation] = -mass[blocks.of_rotation] @ _CROSS[i]
        data[blocks.rotary] += cross_matrices(mass[blocks.rotary][:, i]) / 2
        return data

    def _by_spin(self, i: int, j: int, chosen: NDArray[np.bool_]) -> csr_array:
        blocks, mass = self._blocks, self._blocks.mass.data
        data = _CROSS[i].T @ mass @ _CROSS[j]
        data[blocks.by_rotation] = _TWICE[i, j] @ mass[blocks.by_rotation]
        data[blocks.of_rotation] = mass[blocks.of_rotation] @ _TWICE[i, j]
        if not blocks.rotary.any():
            return blocks.matrix(data, chosen)
        # Only the part symmetric in i, j and in both arguments contributes to the energy.
        inertia, second = mass[blocks.rotary], np.zeros_like(data)
        for a, b in ((i, j), (j, i)):
            turned = _AXES[b][:, None] * inertia[:, None, a] - inertia[:, a, b, None, None] * _AXES
            second[blocks.rotary] += turned / 2
        added = blocks.matrix(second)
        return csr_array(blocks.matrix(data, chosen) + (added + added.T) / 2)

    def rate_products(self, fields: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """`B_i^T q` and `B_i q`, (3, n, ...) each, for fields (n, ...)."""
        fields = fields if self._rest is None else self._rest @ fields
        turned = self._over_blocks(_CROSS, fields)
        transposed, plain = turned, -turned
        if self._rates_beside_points is not None:
            back, forth = self._rates_beside_points
            transposed += (back @ fields).reshape(turned.shape)
            plain += (forth @ fields).reshape(turned.shape)
        return self._gathered(transposed, 1), self._gathered(plain, 1)

    def spin_products(self, fields: NDArray[np.float64]) -> NDArray[np.float64]:
        """`Z_ij q`, (3, 3, n, ...), for fields (n, ...)."""
        fields = fields if self._rest is None else self._rest @ fields
        result = self._over_blocks(_TWICE, fields)
        if self._spins_beside_points is not None:
            result += (self._spins_beside_points @ fields).reshape(result.shape)
        return self._gathered(result, 2)

    def _over_blocks(self, turns: NDArray[np.float64], fields: NDArray[np.float64]) -> NDArray[np.float64]:
        """Products of `turns` (..., 3, 3) with the momenta of the point masses for fields (n, ...).

        The result has the shape (..., n, ...), the leading axes from `turns`.
        """
        # All lengths are stated, because fields may have no columns.
        number, points, columns = turns.size // 9, len(fields) // 3, fields[0].size
        momenta = (self._points @ fields).reshape(points, 3, columns)
        rotated = turns.reshape(-1, 3) @ momenta.swapaxes(0, 1).reshape(3, points * columns)
        by_point = rotated.reshape(number, 3, points, columns).swapaxes(1, 2)
        return by_point.reshape(*turns.shape[:-2], *fields.shape)

    @cached_property
    def by_both(self) -> NDArray[np.float64]:
        """`k_ij` (3, 3, n); k_ii is the load of unit angular velocity about i on the undeformed body.

        Only k_ij + k_ji enters the energy. The skew part is chosen so that 2 w_j k_ij . q' is the Coriolis
        moment, J' w + w x (P . q'). For points, k_ij . q = m (e_i x x) . (e_j x q).
        """
        blocks, mass = self._blocks, self._blocks.mass.data
        rotations = self._rigid_modes[:, 3:]
        angular = self._mass @ rotations
        momenta = angular.reshape(-1, 3, 3)
        beside, rotary = (blocks.matrix(mass, chosen) for chosen in (blocks.by_rotation, blocks.rotary))
        own = (rotary @ rotations).reshape(-1, 3, 3)
        turns, result = blocks.turns[:, None, None], np.zeros((3, 3, len(rotations)))
        for j, cross in enumerate(_CROSS):
            # (e_j x u) . p = u . (p x e_j). For a rotation, only J e_i enters in place of p; the other terms
            # depend on positions.
            places = np.where(turns, 0.0, cross.T @ rotations.reshape(-1, 3, 3))
            through = (beside.T @ places.reshape(-1, 3)).reshape(-1, 3, 3)
            result[:, j] = np.where(turns, cross.T @ own + through, cross.T @ momenta).reshape(-1, 3).T
        # From the mass matrix of the body, which includes modal coordinates; these are not in triples.
        skew = np.einsum("aij,na->ijn", _CROSS, self.body.mass @ self.body.rigid_modes[:, 3:])
        return (self._gathered(result + result.swapaxes(0, 1), 2) - skew) / 2


def _stacked(matrices: Sequence[csr_array]) -> csr_array:
    """Matrices below each other: one product with a vector, instead of one for each matrix."""
    return csr_array(vstack(matrices, format="csr"))


class _Blocks(NamedTuple):
    """The mass matrix in 3 x 3 blocks, each between two translations or rotations."""

    mass: bsr_array
    turns: NDArray[np.bool_]
    """True for block rows that are rotations"""
    by_rotation: NDArray[np.bool_]
    """True for blocks of a translation (row) by a rotation (column)"""
    of_rotation: NDArray[np.bool_]
    """True for blocks of a rotation by a translation"""
    rotary: NDArray[np.bool_]
    """True for blocks of a rotation by a rotation"""
    points: NDArray[np.bool_]
    """True for blocks m I of a translation by a translation"""

    def matrix(self, data: NDArray[np.float64], chosen: NDArray[np.bool_] | None = None) -> csr_array:
        """Sparse (n, n) with the blocks `data`; blocks that are not chosen are zero."""
        if chosen is not None:
            data = np.where(chosen[:, None, None], data, 0.0)
        blocks = bsr_array((data, self.mass.indices, self.mass.indptr), shape=self.mass.shape)
        result = csr_array(blocks)
        result.eliminate_zeros()
        return result
