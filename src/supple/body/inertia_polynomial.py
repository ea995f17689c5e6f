"""Kinetic energy of a body in a floating frame: a polynomial of degree two in its coordinates and rates.

Nodes and rigid interfaces move by `u` and turn by the rotation vector `theta` against the frame, whose
angular velocity is `w`. A node with the inertia J in its own axes turns at
`exp(-theta~) w + (I - theta~/2 + ..) theta'`, so that

    w_n = w + (w x theta + theta') + 1/2 theta x (theta x w) - 1/2 theta x theta'
    T_J = 1/2 w J w + w J (w x theta + theta') + 1/2 (w x theta + theta') J (w x theta + theta')
          + 1/2 w J (theta x (theta x w) - theta x theta')                           + O(|theta|^3)

The third power is left out; `w x theta` carries the gyroscopic moment. A mass that couples the rotations of
two nodes, consistent or condensed, is a bilinear form: theta of the one node stands in the first place, of
the other in the second. A mass that couples translations to rotations is that of a point beside its node, at
u + theta x c.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csr_array

from supple.algebra.cross import cross_matrices, cross_matrix

if TYPE_CHECKING:
    from supple.body.flexible_body import FlexibleBody

__all__ = ["SPIN_PAIRS", "InertiaPolynomial", "inertia_polynomial"]

SPIN_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Which products of the angular velocity the matrices of `by_spin` are of."""

_AXES = np.eye(3)
_CROSS = tuple(cross_matrix(axis) for axis in _AXES)


@dataclass(frozen=True, eq=False)
class InertiaPolynomial:
    """Coefficients, in the body's coordinates, of the kinetic energy about the frame's origin at rest.

        T = 1/2 q' M q' + w_i (P_i . q' + q B_i q') + 1/2 w_i w_j (J_ij + 2 k_ij . q + q Z_ij q)

    `P_i`: columns of M R, of which those of the translations give the momentum of q'.

    by_rate : B_i, 3 of (n, n)
    by_spin : Z_ij of `SPIN_PAIRS`, 6 of (n, n); Z_ji is its transpose
    by_both : k_ij (3, 3, n), not symmetric in i and j
    """

    by_rate: tuple[csr_array, ...]
    by_spin: tuple[csr_array, ...]
    by_both: NDArray[np.float64]


def inertia_polynomial(body: FlexibleBody) -> InertiaPolynomial:
    """The kinetic energy of a body, from the 3 x 3 blocks of its mass matrix."""
    blocks = bsr_array(body.mass.tocsr(), blocksize=(3, 3))
    mass: Any = blocks.data
    rigid = body.rigid_modes.reshape(-1, 3, 6)
    turns = ~np.any(rigid[:, :, :3], axis=(1, 2))
    row, column = np.repeat(turns, np.diff(blocks.indptr)), turns[blocks.indices]
    by_rotation, of_rotation, both = ~row & column, row & ~column, row & column
    rotary = mass[both]

    def matrix(data: NDArray[np.float64]) -> csr_array:
        result = csr_array(bsr_array((data, blocks.indices, blocks.indptr), shape=blocks.shape))
        result.eliminate_zeros()
        return result

    def rate(i: int) -> csr_array:
        data = -_CROSS[i] @ mass
        data[of_rotation] = -mass[of_rotation] @ _CROSS[i]
        data[both] += cross_matrices(rotary[:, i]) / 2
        return matrix(data)

    def spin(i: int, j: int) -> csr_array:
        data = _CROSS[i].T @ mass @ _CROSS[j]
        data[by_rotation] = _CROSS[i].T @ _CROSS[j] @ mass[by_rotation]
        data[of_rotation] = mass[of_rotation] @ _CROSS[i].T @ _CROSS[j]
        if not both.any():
            return matrix(data)
        # Symmetric in i, j and in the two places: of the energy nothing else counts.
        second = np.zeros_like(data)
        for a, b in ((i, j), (j, i)):
            second[both] += (_AXES[b][:, None] * rotary[:, None, a] - rotary[:, a, b, None, None] * _AXES) / 2
        added = matrix(second)
        return csr_array(matrix(data) + (added + added.T) / 2)

    return InertiaPolynomial(
        by_rate=tuple(rate(i) for i in range(3)),
        by_spin=tuple(spin(i, j) for i, j in SPIN_PAIRS),
        by_both=_by_both(body, matrix, mass, turns, by_rotation, both),
    )


def _by_both(body: FlexibleBody, matrix: Any, mass: Any, turns: Any, by_rotation: Any, both: Any) -> Any:
    """k_ij: work of the momenta of a unit rotation i on what a unit rotation j makes of q."""
    moved = body.rigid_modes[:, 3:]
    momenta = (body.mass @ moved).reshape(-1, 3, 3)
    coupling, rotary = (matrix(np.where(chosen[:, None, None], mass, 0.0)) for chosen in (by_rotation, both))
    own = (rotary @ moved).reshape(-1, 3, 3)
    result = np.zeros((3, 3, body.n))
    for j, cross in enumerate(_CROSS):
        # (e_j x u) . p = u . (p x e_j); of a rotation, J e_i alone is turned: the rest is of places.
        turned_places = np.where(turns[:, None, None], 0.0, cross.T @ moved.reshape(-1, 3, 3))
        through = (coupling.T @ turned_places.reshape(-1, 3)).reshape(-1, 3, 3)
        found = np.where(turns[:, None, None], cross.T @ own + through, cross.T @ momenta)
        result[:, j] = found.reshape(-1, 3).T
    return result
