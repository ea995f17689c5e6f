"""A body as small matrices with interface coordinates: the result of a substructuring method."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy import linalg

from supple.algebra import Eigenpairs, ReadOnlyArrays, read_only
from supple.errors import AccuracyError, ModelError

__all__ = ["ComponentModel", "ReducedMatrices", "RitzComponent"]

# Eigenvalue of the mass scaled to a unit diagonal, divided by r, up to which a direction is dependent.
DEPENDENT = 1e-13


@dataclass(frozen=True, eq=False)
class ReducedMatrices(ReadOnlyArrays):
    """An eigenproblem K x = lambda M x in a few coordinates.

    stiffness : (r, r)      symmetric
    mass : (r, r)           symmetric, positive definite except for dependent coordinates
    n_forces : int          number of coordinates that are interface forces. Each makes one eigenvalue
                            negative, which belongs to no vibration
    """

    stiffness: np.ndarray
    mass: np.ndarray
    n_forces: int = 0

    @property
    def r(self) -> int:
        """Number of coordinates."""
        return len(self.stiffness)

    @cached_property
    def spectrum(self) -> np.ndarray:
        """All eigenvalues (rad^2/s^2), ascending, of vibrations and rigid motions, not of interface forces.

        Dependent coordinates contribute none.
        Raises AccuracyError when the mass is indefinite, or where interface forces are dependent.
        """
        columns = self._orthonormal_columns()
        return read_only(np.linalg.eigvalsh(self._projected(columns))[self.n_forces :])

    def modes(self) -> Eigenpairs:
        """The eigenvalues of `spectrum`, and their vectors (r, k) with X^T M X = I."""
        columns = self._orthonormal_columns()
        values, vectors = np.linalg.eigh(self._projected(columns))
        return Eigenpairs(values[self.n_forces :], columns @ vectors[:, self.n_forces :])

    def eigenvalues(self, n: int) -> np.ndarray:
        """The n lowest eigenvalues of the spectrum; ModelError when there are fewer."""
        if not 1 <= n <= self.spectrum.size:
            raise ModelError(f"{n} eigenvalues requested of a reduced body that has {self.spectrum.size}")
        return self.spectrum[:n]

    def _orthonormal_columns(self) -> np.ndarray:
        """M-orthonormal combinations (r, k) of the coordinates; AccuracyError as for `spectrum`."""
        diagonal = np.diag(self.mass)
        scale = 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        squares, directions = np.linalg.eigh(scale[:, None] * self.mass * scale)
        if not squares[0] > -DEPENDENT * self.r:
            raise AccuracyError(
                f"the reduced mass is indefinite: its smallest eigenvalue, diagonal scaled to one, is "
                f"{squares[0]:.1e}; check that modes and static columns belong to one body"
            )
        kept = squares > DEPENDENT * self.r
        if self.n_forces and not kept.all():
            raise AccuracyError(
                f"the residual shapes of {self.n_forces} interface forces depend on one another: some "
                "forces cannot be distinguished; keep fewer modes, or use Rubin"
            )
        return scale[:, None] * directions[:, kept] / np.sqrt(squares[kept])

    def _projected(self, columns: np.ndarray) -> np.ndarray:
        projected = columns.T @ self.stiffness @ columns
        return 0.5 * (projected + projected.T)


def block_diagonal(*blocks: np.ndarray) -> np.ndarray:
    """A matrix of square blocks along the diagonal."""
    return np.asarray(linalg.block_diag(*blocks))


class ComponentModel(Protocol):
    """A reduced body whose interfaces may be left free, fixed in space, or joined to rigid bodies."""

    def interfaces_free(self) -> ReducedMatrices:
        """Matrices with no load at the interfaces."""
        ...

    def interfaces_fixed(self) -> ReducedMatrices:
        """Matrices with all interfaces fixed in space."""
        ...

    def interfaces_loaded(self, added_mass: np.ndarray) -> ReducedMatrices:
        """Matrices with rigid bodies of mass added_mass (b, b), symmetric, at the interface motions."""
        ...


@dataclass(frozen=True, eq=False)
class RitzComponent(ReadOnlyArrays):
    """A body projected on the columns V of a basis; its eigenvalues are not below those of the full body.

    stiffness, mass : (r, r)        V^T K V and V^T M V
    interface_motion : (b, r)       B V, b = 6 n_interfaces
    """

    stiffness: np.ndarray
    mass: np.ndarray
    interface_motion: np.ndarray

    def interfaces_free(self) -> ReducedMatrices:
        """V^T K V and V^T M V."""
        return ReducedMatrices(self.stiffness, self.mass)

    def interfaces_fixed(self) -> ReducedMatrices:
        """V^T K V and V^T M V on motions with the interfaces at rest, B V x = 0."""
        lengths = 1.0 / np.sqrt(np.diag(self.mass))
        motion = self.interface_motion * lengths
        rest = lengths[:, None] * linalg.null_space(motion / np.linalg.norm(motion, axis=1)[:, None])
        return ReducedMatrices(rest.T @ self.stiffness @ rest, rest.T @ self.mass @ rest)

    def interfaces_loaded(self, added_mass: np.ndarray) -> ReducedMatrices:
        """M + (B V)^T M_added (B V)."""
        motion = self.interface_motion
        return ReducedMatrices(self.stiffness, self.mass + motion.T @ added_mass @ motion)
