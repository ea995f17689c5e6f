"""Eigenvalues and mode shapes of a machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg

from supple.errors import ModelError
from supple.linearization.linear_machine import LinearMachine
from supple.linearization.slowest_motions import slowest_motions
from supple.linearization.sparse_machine import SparseMachine

__all__ = ["MachineModes", "machine_modes"]


@dataclass(frozen=True, eq=False)
class MachineModes:
    """Free motions `p(t) = Re( shape exp(eigenvalue t) )` of a linearised machine, slowest first.

    eigenvalues : complex (k,)      1/s, of a conjugate pair the one above the real axis, of both zeros of a
        free rigid motion one; others that are real, alone
    shapes : complex (n, k)         of frames and deformation coordinates, in the frames' own axes, of unit
        kinetic energy norm `shape^H M shape = 1`, the largest independent coordinate real
    independent : complex (m, k)    the same in the coordinates of the `LinearMachine`
    """

    machine: LinearMachine
    eigenvalues: Any
    independent: Any

    @property
    def shapes(self) -> np.ndarray:
        """Of frames and deformation coordinates, (n, k)."""
        return self.machine.basis @ self.independent

    @property
    def frequencies(self) -> np.ndarray:
        """Damped angular frequencies, rad/s, (k,); zero for motions that do not oscillate."""
        return self.eigenvalues.imag

    @property
    def damping_ratios(self) -> np.ndarray:
        """`-Re(s) / |s|`, (k,): negative for unstable modes, 0 for rigid motions."""
        size = abs(self.eigenvalues)
        return np.where(size > 0, -self.eigenvalues.real / np.where(size > 0, size, 1.0), 0.0)

    @property
    def kinetic_shares(self) -> np.ndarray:
        """Each body's part of the kinetic energy, in axes that turn along, (nb, k); columns add up to 1."""
        machine, shapes = self.machine, self.shapes
        weighted = np.real(shapes.conj() * (machine.full_mass @ shapes))
        sizes = [6 + placed.body.n_coordinates for placed in machine.system.bodies]
        starts = np.cumsum([0, *sizes[:-1]])
        energies = np.add.reduceat(weighted, starts, axis=0)
        return energies / energies.sum(axis=0)

    @property
    def unstable(self) -> np.ndarray:
        """Which modes grow by more than round-off explains, (k,)."""
        # Round-off is in parts of the fastest motion, also where that is not among the modes.
        squares = abs(np.diag(self.machine.stiffness)) / np.diag(self.machine.mass)
        largest = max(float(np.max(abs(self.eigenvalues))), float(np.sqrt(squares.max())))
        return self.eigenvalues.real > 1e-7 * largest


def machine_modes(machine: LinearMachine | SparseMachine, n_modes: int | None = None) -> MachineModes:
    """The slowest modes of a linearised machine, all of them unless told how many.

        ( s^2 M + s C + K ) y = 0

    Two poles of a machine that moves freely lie at s = 0, exactly only to round-off: those within
    `sqrt(1e-13)` of the largest are said to be 0.

    Of a machine with full bodies the slowest are found by shift and invert (`slowest_motions`); with damping
    or gyroscopic terms these are the slowest of which iteration shows any.

    Raises
    ------
    ModelError      a number that is not positive; all modes of a large machine with full bodies
    AccuracyError   modes of such a machine that do not settle
    """
    if n_modes is not None and not (n_modes >= 1 and n_modes == int(n_modes)):
        raise ModelError(f"number of modes must be a whole number, at least 1, got {n_modes}")
    n_modes = None if n_modes is None else int(n_modes)
    if isinstance(machine, SparseMachine):
        machine = machine.along(slowest_motions(machine, n_modes, _pairs))
    values, y = _pairs(machine)
    values, y = values[:n_modes], y[:, :n_modes]
    largest = np.take_along_axis(y, np.argmax(abs(y), axis=0)[None], axis=0)[0]
    return MachineModes(machine, values, y * (abs(largest) / largest))


def _pairs(machine: LinearMachine) -> tuple[Any, Any]:
    """Eigenvalues and modes (k, ..) of unit kinetic energy norm, slowest first."""
    k = machine.size
    lower = np.linalg.cholesky(machine.mass)
    damping, stiffness = (
        scipy.linalg.solve_triangular(
            lower, scipy.linalg.solve_triangular(lower, part.T, lower=True).T, lower=True
        )
        for part in (machine.damping, machine.stiffness)
    )
    # Velocities in units of a typical frequency, so that both halves of the state are of one size.
    unit = np.sqrt(np.linalg.norm(stiffness)) or 1.0
    state = np.block([[np.zeros((k, k)), unit * np.eye(k)], [-stiffness / unit, -damping]])
    values: Any
    values, vectors = np.linalg.eig(state)
    values = np.where(abs(values) < 3e-7 * unit / np.sqrt(k), 0.0, values)
    kept = values.imag >= 0
    # Each free rigid motion has two poles at zero, its place and its rate: they count as one mode.
    kept[np.flatnonzero(values == 0)[1::2]] = False
    values, vectors = values[kept], vectors[:k, kept]
    order = np.lexsort((values.real, abs(values)))
    y = scipy.linalg.solve_triangular(lower.T, vectors[:, order])
    sizes = np.sqrt(np.real(np.einsum("ij,ij->j", y.conj(), machine.mass @ y)))
    return values[order], y / sizes
