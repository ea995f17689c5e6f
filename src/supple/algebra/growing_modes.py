"""The lowest modes of a clamped structure when their number is not known in advance."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import linalg, sparse

from supple.algebra.constrained_solve import ConstrainedFactor
from supple.algebra.eigen import Eigenpairs, lowest_modes
from supple.algebra.tall_matrix import TallMatrix
from supple.arrays import FloatArray
from supple.errors import AccuracyError, ModelError

__all__ = ["GrowingModes", "RitzModes"]


# Eight right-hand sides take twice the time of one; wider blocks need a longer Krylov space.
BLOCK = 8

# Relative distance within which modes count as multiple.
CLOSE = 1e-5

# Residual of a mode in its equation: the error of its eigenvalue is of the order of the squared residual.
LARGEST_RESIDUAL = 1e-7

# Number of Krylov vectors: some blocks, and some vectors per requested mode. If too few modes converge, the
# number grows by at least SMALLEST_GROWTH.
FIRST_BLOCKS = 9
VECTORS_PER_MODE = 2.65
SMALLEST_GROWTH = 1.05


@dataclass(frozen=True, eq=False)
class RitzModes:
    """M-orthonormal modes basis @ weights, formed on request.

    values  : (k,)          eigenvalues, rad^2/s^2, ascending
    basis   : TallMatrix    (n, m), M-orthonormal
    weights : (m, k)        orthonormal
    """

    values: FloatArray
    basis: TallMatrix
    weights: FloatArray = field(repr=False)

    @classmethod
    def of(cls, modes: Eigenpairs) -> RitzModes:
        """Modes given as vectors."""
        return cls(modes.values, TallMatrix((modes.vectors,)), np.eye(modes.values.size))

    @cached_property
    def vectors(self) -> FloatArray:
        """The modes (n, k)."""
        return self.basis.times(self.weights)

    def participation(self, loads: FloatArray) -> FloatArray:
        """Work (k, b) of loads (n, b) on each mode, Phi^T loads."""
        return self.weights.T @ self.basis.transposed_times(loads)

    def combine(self, amounts: FloatArray) -> FloatArray:
        """The motion Phi @ amounts (n, b) of amounts (k, b)."""
        return self.basis.times(self.weights @ amounts)


class GrowingModes:
    """The lowest modes of K x + D^T mu = lambda M x, D x = 0, as many as requested, extendable.

    Block Lanczos on K^-1 M (constrained) with full reorthogonalisation and no restart. A longer list costs
    only the additional modes; all lists together cost no more than the longest. The Krylov space Q and the
    projected inverse T = Q^T M K^-1 M Q only grow. Where Q would span half of a small problem, a dense
    solution finds all modes. A block of b columns finds at most b copies of a multiple eigenvalue (the equal
    blades of a clamped hub): if it finds as many, Q restarts with a block twice as wide.

    inverse : ConstrainedFactor     of the clamped stiffness
    mass    : csc (n, n)            symmetric, positive definite
    """

    def __init__(self, inverse: ConstrainedFactor, mass: sparse.csc_array):
        self.inverse, self.mass = inverse, mass
        self._begin(BLOCK)

    def _begin(self, width: int) -> None:
        """An empty Krylov space with blocks of the given width."""
        n = self.inverse.n
        self.width = width
        self.basis = TallMatrix((np.empty((n, 0)),))
        self.last_block = self.last_inertia = np.empty((n, 0))
        self.projected = np.empty((0, 0))
        self.found = RitzModes(np.empty(0), self.basis, np.empty((0, 0)))
        if width <= self.available:
            start = self.inverse.solve(self.mass @ np.random.default_rng(0).standard_normal((n, width)))
            self.next_block, self.next_inertia, self.coupling = self._orthonormal(start)

    @property
    def available(self) -> int:
        """Number of all modes."""
        return self.inverse.n - len(self.inverse.constraint)

    def at_least(self, n_modes: int) -> RitzModes:
        """The lowest modes, n_modes or more of them, that satisfy their equation to 1e-7.

        Raises
        ------
        ModelError      more modes than there are
        AccuracyError   a motion without mass, or with negative mass; a motion softer than the round-off
        """
        if n_modes > self.available:
            raise ModelError(
                f"{n_modes} modes requested of a structure with {self.available} freedoms: request fewer"
            )
        while self.found.values.size < n_modes:
            known = self.basis.n_columns
            wanted = FIRST_BLOCKS * self.width + VECTORS_PER_MODE * n_modes
            wanted = max(wanted, SMALLEST_GROWTH * known)
            reach = known + self.width * int(np.ceil((wanted - known) / self.width))
            if reach + self.width > self.available // 2:
                everything = lowest_modes(
                    self.inverse.grounded.stiffness,
                    self.mass,
                    self.available,
                    constraint=self.inverse.constraint,
                )
                if not everything.values[0] > 0:
                    raise AccuracyError(
                        f"the lowest eigenvalue of the structure is {everything.values[0]:.1e}: a "
                        "motion is so soft that rounding errors of the stiffest one exceed its stiffness; "
                        "check units, thicknesses and supports"
                    )
                self.found = RitzModes.of(everything)
            else:
                self._grow(reach)
                self.found = self._converged_modes()
                if _fills_a_block(self.found.values, self.width):
                    self._begin(2 * self.width)
        return self.found

    def keep_modes_only(self) -> None:
        """Release the memory of the Krylov space except for the modes found in it (a thick restart).

        More modes can still be requested; their space is then built again.
        """
        self.found = RitzModes.of(Eigenpairs(self.found.values, self.found.vectors))
        self.basis, self.projected = self.found.basis, np.diag(1 / self.found.values)
        self.last_block = self.last_inertia = np.empty((self.inverse.n, 0))  # no longer part of the space

    def _grow(self, size: int) -> None:
        """Extend Q to (n, size)."""
        done = self.basis.n_columns
        fresh = np.empty((self.inverse.n, size - done), order="F")
        projected = np.zeros((size, size))
        projected[:done, :done] = self.projected
        for first in range(done, size, self.width):
            m = first + self.width
            fresh[:, first - done : m - done] = self.next_block
            basis = self.basis.with_block(fresh[:, : m - done])
            images = self.inverse.solve(self.next_inertia)
            # Orthogonalise against the last two blocks (Lanczos recurrence), then against all (round-off).
            coupled = TallMatrix((self.last_block, self.next_block))
            parts = TallMatrix((self.last_inertia, self.next_inertia)).transposed_times(images)
            images -= coupled.times(parts)
            projected[m - len(parts) : m, first:m] += parts
            parts = basis.transposed_times(self.mass @ images)
            images -= basis.times(parts)
            projected[:m, first:m] += parts
            self.last_block, self.last_inertia = self.next_block, self.next_inertia
            self.next_block, self.next_inertia, self.coupling = self._orthonormal(images)
        self.basis, self.projected = self.basis.with_block(fresh), projected

    def _converged_modes(self) -> RitzModes:
        """Ritz pairs of T; the coupling to the next block gives the residual of each."""
        upper = np.triu(self.projected)
        mu, weights = linalg.eigh(upper + np.triu(self.projected, 1).T)
        mu, weights = mu[::-1], weights[:, ::-1]
        residuals = np.linalg.norm(self.coupling @ weights[-self.width :], axis=0)
        converged = residuals <= LARGEST_RESIDUAL * mu
        count = mu.size if converged.all() else int(np.argmin(converged))
        return RitzModes(1 / mu[:count], self.basis, weights[:, :count])

    def _orthonormal(self, block: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Q, M Q, R with block = Q R, Q^T M Q = I; by Cholesky, repeated for lost digits."""
        inertia, lower = block, np.eye(self.width)
        triangle = lower
        for _ in range(2):
            inertia = self.mass @ block
            try:
                lower = np.linalg.cholesky(block.T @ inertia)
            except np.linalg.LinAlgError as error:
                raise AccuracyError(
                    "the Krylov space of the modes ends early: some motion has no mass, or the mass "
                    "matrix is not positive definite"
                ) from error
            block = linalg.solve_triangular(lower, block.T, lower=True).T
            triangle = lower.T @ triangle
        return block, linalg.solve_triangular(lower, inertia.T, lower=True).T, triangle


def _fills_a_block(values: FloatArray, width: int) -> bool:
    """Whether `width` of the values are equal: this eigenvalue may then have more copies than were found."""
    return bool(np.any(values[width - 1 :] <= (1 + CLOSE) * values[: max(values.size - width + 1, 0)]))
