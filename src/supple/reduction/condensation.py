"""Static condensation of the motion outside the columns of a basis, its energy, and the choice of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.sparse import csc_array

from supple.arrays import FloatArray
from supple.body import FlexibleBody, Frame, NodalFixedFrame, frame_projector
from supple.reduction.bases.guyan import interface_shapes
from supple.reduction.condensed_inertia import condensed_moments
from supple.reduction.condensed_motion import CondensedMotion
from supple.reduction.reduction_basis import ReductionBasis
from supple.reduction.tensors import StrainProducts

__all__ = ["Condensation", "CondensedQuartic", "PlainQuartic", "QuarticChoice"]

# Largest number of entries of the pair forces (n, pairs) in memory (128 MiB); more are evaluated in blocks of
# pairs, with FEWEST_AT_ONCE pairs or more in each.
NUMBERS_AT_ONCE = 2**24
FEWEST_AT_ONCE = 16

# Eigenvalues of the Gram matrix of columns of unit energy, at or below which a combination is dropped: basis
# columns that depend on one another, and interface shapes that depend on the basis.
DEPENDENT = 1e-12
DEPENDENT_ON_BASIS = 1e-8

# Energy of the motion of a pair outside the fields of z, relative to the largest energy of a whole motion of
# a pair; below this value no field is added. Bending fields have large displacements at little energy: 1e-10
# neglects a thousandth of the motion, 1e-8 six thousandths.
SMALLEST_SHARE = 1e-10

RIGID = 6
"""Number of rigid motions, which have no strain energy."""


@dataclass(frozen=True, eq=False)
class Condensation:
    """The motion z of a nonlinear body outside the columns V of a basis, static for given coordinates gamma.

    The strain energy is U(q) = 1/2 |B q + 1/2 N(q, q)|^2, with linear strains B q, quadratic strains
    1/2 N(q, q) and the norm |e|^2 = sum w e^T D e over the integration points. The motion z is K-orthogonal
    to V. To leading order, the terms N(q, z) and N(z, z) are neglected:

        U_c(gamma) = min_z 1/2 |B (V gamma + z) + 1/2 N(V gamma, V gamma)|^2
                   = U(V gamma) - 1/8 s^T R s >= 0,     s_(jk) = gamma_j gamma_k, twice for j < k
        K t_jk = -sum w B^T D N(G V_j, G V_k),          R = Gram matrix, in the K-norm, of the (1 - P) t_jk
        z(gamma) = 1/2 sum_jk gamma_j gamma_k (1 - P) t_jk

    G V_j are the displacement gradients of column j; P is the K-orthogonal projector on the columns and the
    static shapes of the interfaces. Without z, a basis that lacks a stiff motion, such as the shortening of a
    bent beam, is too stiff. The neglected N(q, z) contributes a share of the work of the order of theta^2 at
    any slenderness: 0.41 theta^2 for a beam under uniform load whose tip rotates by theta. A basis with
    derivative columns includes this contribution. Joints and interface loads act on V gamma alone, so z must
    not move one interface relative to another: z is also K-orthogonal to the static shapes of the interfaces,
    which most bases contain.

    body : FlexibleBody         with quadratic strains
    basis : ReductionBasis      of this body
    Source: original to this project; the condensed static derivatives are those of [Idelsohn1985].
    """

    body: FlexibleBody
    basis: ReductionBasis

    @cached_property
    def energy(self) -> FloatArray:
        """R (n2, n2), positive semidefinite, of the pairs j <= k of columns; n2 = r(r+1)/2."""
        energy = self._energy_of_all - self._held.T @ self._held
        return (energy + energy.T) / 2

    @cached_property
    def interface_energy(self) -> FloatArray:
        """Increase (n2, n2) of R if z could move the interfaces; zero if the basis contains their shapes."""
        held = self._held[self._columns.shape[1] :]
        return held.T @ held

    def motion(self) -> CondensedMotion:
        """The motion z at the nodes, in fields orthonormal in the strain energy, with its inertia moments."""
        first, second = self._pairs
        scale = np.sum(self.basis.vectors * (self.body.stiffness @ self.basis.vectors), axis=0) ** -0.5
        unit = scale[first] * scale[second]  # scales the motion of a pair to columns of unit energy
        largest = np.max(unit**2 * np.diag(self._energy_of_all))
        (pivoted_cholesky,) = linalg.get_lapack_funcs(("pstrf",), (self.energy,))
        factor, order, rank, _ = pivoted_cholesky(
            unit[:, None] * self.energy * unit, tol=SMALLEST_SHARE * largest, lower=1
        )
        # With a complete basis R is round-off, so the rank is limited to the number of freedoms that remain.
        held = self._columns.shape[1] + self._interfaces.shape[1] + RIGID
        rank = min(rank, self.body.n - held)
        factor, order = np.tril(factor)[:, :rank], order - 1
        spanning = order[:rank]
        forces = self._forces_of(spanning)
        motions = linalg.solve_triangular(
            factor[:rank], (self._outside(forces) * unit[spanning]).T, lower=True
        )
        amplitudes = np.empty((rank, len(order)))
        amplitudes[:, order] = factor.T
        fields = self.body.expansion @ frame_projector(self.body, self._resting)(motions.T)
        amplitudes = amplitudes * (np.where(first == second, 0.5, 1.0) / unit)
        moments = condensed_moments(self.body, fields, amplitudes) if rank else None
        return CondensedMotion(fields, amplitudes, moments)

    def bilinear(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """The symmetric bilinear form z(a, b), (n, k), of k pairs of coordinates a, b (k, r); z(a, a) = z(a).

        The motion is relative to the frame of the basis. Each pair needs one static solution.
        """
        numbers = np.arange(len(a))
        moved = np.hstack([self.basis.vectors @ a.T, self.basis.vectors @ b.T])
        forces = self.body.assembly.strain_pair_forces(moved, numbers, numbers + len(a))
        return 0.5 * frame_projector(self.body, self.basis.frame)(self._outside(forces))

    def rigid_part(self, moved: FloatArray) -> FloatArray:
        """Rigid motion rho (6, k) such that z + R rho leaves the first interface at rest.

        The displacements of the reduced body contain z + R rho; rho is a translation and a rotation in the
        body's axes.

        moved : (n, k)   z of `bilinear`
        """
        D, R = self._resting.constraint(self.body), self.body.rigid_modes
        return -np.linalg.inv(D @ R) @ (D @ moved)

    @property
    def _resting(self) -> Frame:
        """A frame fixed to the first interface; without interfaces, the frame of the basis."""
        interfaces = self.body.interfaces
        return NodalFixedFrame(interfaces[0].name) if interfaces else self.basis.frame

    def _outside(self, forces: FloatArray) -> FloatArray:
        """Motions (n, k) due to pair forces (n, k), less their part in the columns and interface shapes."""
        held = np.hstack([self._columns, self._interfaces])
        return held @ (held.T @ forces) - self.body.grounded_stiffness.factor.solve(forces)

    @cached_property
    def _pairs(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        return np.triu_indices(self.basis.r)

    @cached_property
    def _blocks(self) -> tuple[slice, ...]:
        size, n2 = max(FEWEST_AT_ONCE, NUMBERS_AT_ONCE // self.body.n), len(self._pairs[0])
        return tuple(slice(start, min(start + size, n2)) for start in range(0, n2, size))

    @cached_property
    def _forces(self) -> Callable[[slice], FloatArray]:
        """Function that returns the forces (n, size) of a block of pairs; it caches the last block."""
        first, second = self._pairs

        @lru_cache(maxsize=1)
        def between(start: int, stop: int) -> FloatArray:
            pairs = slice(start, stop)
            return self.body.assembly.strain_pair_forces(self.basis.vectors, first[pairs], second[pairs])

        return lambda block: between(block.start, block.stop)

    def _forces_of(self, spanning: NDArray[np.intp]) -> FloatArray:
        """Forces (n, k) of k pairs, from the cached block if there is only one block."""
        first, second = self._pairs
        if len(self._blocks) == 1:
            return self._forces(self._blocks[0])[:, spanning]
        return self.body.assembly.strain_pair_forces(self.basis.vectors, first[spanning], second[spanning])

    @cached_property
    def _energy_of_all(self) -> FloatArray:
        """Gram matrix (n2, n2), in the K-norm, of the whole motions t_jk: f^T K^-1 f, with K t = -f."""
        n2 = len(self._pairs[0])
        energy = np.empty((n2, n2))
        for i, block in enumerate(self._blocks):
            responses = self.body.grounded_stiffness.factor.solve(self._forces(block))
            for other in self._blocks[i:]:
                energy[block, other] = responses.T @ self._forces(other)
                energy[other, block] = energy[block, other].T
        return energy

    @cached_property
    def _held(self) -> FloatArray:
        """(q, n2): work of the pair forces on the q K-orthonormal columns and interface shapes."""
        shapes = np.hstack([self._columns, self._interfaces])
        return np.hstack([shapes.T @ self._forces(block) for block in self._blocks])

    @cached_property
    def _columns(self) -> FloatArray:
        """The basis, K-orthonormal."""
        return _orthonormalized(self.basis.vectors, self.body.stiffness)

    @cached_property
    def _interfaces(self) -> FloatArray:
        """Static interface shapes outside the columns, K-orthonormal; the first interface is fixed."""
        if len(self.body.independent_interfaces) < 2:
            return np.empty((self.body.n, 0))
        return _orthonormalized(interface_shapes(self.body)[:, 6:], self.body.stiffness, self._columns)


def _orthonormalized(
    shapes: FloatArray, stiffness: csc_array, before: FloatArray | None = None
) -> FloatArray:
    """K-orthonormal columns that span the part of `shapes` outside the K-orthonormal columns `before`."""
    scaled = shapes / np.sqrt(np.sum(shapes * (stiffness @ shapes), axis=0))
    smallest = DEPENDENT
    if before is not None:
        smallest = DEPENDENT_ON_BASIS
        for _ in range(2):  # the second pass removes the round-off of the first
            scaled = scaled - before @ (before.T @ (stiffness @ scaled))
    values, vectors = np.linalg.eigh(scaled.T @ (stiffness @ scaled))
    kept = values > smallest
    return scaled @ (vectors[:, kept] / np.sqrt(values[kept]))


class QuarticChoice(Protocol):
    """CondensedQuartic() or PlainQuartic()."""

    def strains(self, plain: StrainProducts, left_out: Condensation) -> StrainProducts:
        """Strain products of the reduced body, from those of its columns alone."""
        ...

    def motion(self, left_out: Condensation) -> CondensedMotion | None:
        """The condensed motion z; None if no motion is condensed."""
        ...


@dataclass(frozen=True)
class CondensedQuartic:
    """Motion outside the columns follows the columns statically; see `Condensation`.

    The body does not lock if its basis contains the static shapes of the interfaces.
    """

    def strains(self, plain: StrainProducts, left_out: Condensation) -> StrainProducts:
        """Strain products of the columns, less those that the condensed motion releases."""
        return plain.condensed(left_out.energy)

    def motion(self, left_out: Condensation) -> CondensedMotion | None:
        """The condensed motion."""
        return left_out.motion()


@dataclass(frozen=True)
class PlainQuartic:
    """The body moves in its columns alone, as in published work; it locks where they lack stiff motion."""

    def strains(self, plain: StrainProducts, left_out: Condensation) -> StrainProducts:  # noqa: ARG002
        """The strain products of the columns, unchanged."""
        return plain

    def motion(self, left_out: Condensation) -> CondensedMotion | None:  # noqa: ARG002
        """None."""
        return None
