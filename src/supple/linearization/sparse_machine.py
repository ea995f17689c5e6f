"""A linearised machine with full bodies, in the degrees of freedom of their finite elements."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array

from supple.algebra import mass_orthonormalize
from supple.algebra.bordered_factor import BorderedFactor, bordered_factor
from supple.errors import AccuracyError
from supple.linearization.linear_machine import Array, LinearMachine
from supple.machine import Spin, System
from supple.methods.floating.full.linear_equations import SparseEquations

__all__ = ["SparseMachine"]

LARGEST_DENSE = 1000
"""Largest number of independent freedoms for which all motions are found at once."""

_FIRST, _MOST, _ROUNDS = 4, 36, 12
"""Number of motions for finding the shift, in addition to six rigid ones per body; largest number of these
rigid ones; number of attempts."""

_FROM_MODES = 0.3
"""Ratio of the shift to the frequency of the fastest of these motions; rounding hides far slower modes."""

_FREE = 1e-4
"""Ratio of frequency to shift below which all these motions count as free."""


@dataclass(frozen=True, eq=False)
class SparseMachine:
    """Small motions `p` of a machine with full bodies at rest, or in steady rotation.

        M p'' + C p' + K p + A^T l = 0,      A p = 0

    `p` contains per body the translation and the rotation of its frame, in the frame's own axes, and its
    coordinates. Modes are computed from its slowest motions; no dense (n, n) matrix is formed.

    system    : System          in its equilibrium
    spin      : Spin | None
    time      : float           at which loads and laws are evaluated
    equations : SparseEquations     M, C, K and the constraints A, of joints and body frames
    """

    system: System
    spin: Spin | None
    time: float
    equations: SparseEquations

    @cached_property
    def size(self) -> int:
        """Number of independent freedoms."""
        constraints, n = self.equations.constraint.shape
        return n - constraints

    @cached_property
    def slow(self) -> SlowMotions:
        """A factorised shifted matrix, and a few slow motions; AccuracyError if no shift is found."""
        rigid = 6 * len(self.system.bodies)
        return _slow_motions(self.equations, min(rigid, _MOST, self.size - _FIRST) + _FIRST)

    @cached_property
    def all_motions(self) -> Array:
        """`N` (n, k) of all motions, mass-orthonormal, for a small machine."""
        free = scipy.linalg.null_space(self.equations.constraint.toarray())
        mass, stiffness = (free.T @ (part @ free) for part in (self.equations.mass, self.equations.stiffness))
        return free @ slow_first(mass, stiffness, self.slow.shift**2)

    def along(self, basis: Array) -> LinearMachine:
        """The machine restricted to some motions (n, k)."""
        return LinearMachine.along(basis, self.equations, self.system, self.spin, self.time)


def slow_first(mass: Array, stiffness: Array, square: float) -> Array:
    """Mass-orthonormal motions (k, k) that separate slow and stiff ones: undamped vibrations, slowest first.

    The rounding error of an eigenvalue is relative to the largest matrix entry; in mixed coordinates this is
    the stiffest spring. Slow motions, computed as the highest eigenvalues of the inverse, are accurate
    relative to their own size.

    square : shift of the inverse, (rad per unit of time)^2
    """
    while True:
        try:
            values, motions = scipy.linalg.eigh(mass, (stiffness + stiffness.T) / 2 + square * mass)
        except scipy.linalg.LinAlgError:  # unstable by buckling or centrifugal force at that rate
            square *= 10
            continue
        return (motions / np.sqrt(values))[:, ::-1]


@dataclass(frozen=True, eq=False)
class SlowMotions:
    """`( K + z C + z^2 M )^-1` at a shift z, on motions that satisfy the constraints; a few slow motions.

    shift : z, rad per unit of time
    motions : (n, k), mass-orthonormal
    """

    shift: float
    factor: BorderedFactor
    motions: Array


def _slow_motions(equations: SparseEquations, number: int) -> SlowMotions:
    """Slow motions by subspace iteration, with a shift of the size of their frequencies."""
    mass, stiffness = equations.mass, equations.stiffness
    n = mass.shape[0]
    squares = abs(stiffness.diagonal()) / np.where(mass.diagonal() > 0, mass.diagonal(), np.inf)
    shift = np.sqrt(1e-9 * float(squares.max()) or 1.0)
    block = np.random.default_rng(0).standard_normal((n, number))
    for _ in range(_ROUNDS):
        try:
            factor = _shifted(equations, shift)
        except AccuracyError:  # an unstable machine may grow at just this rate
            shift *= 1.37
            continue
        for _ in range(3):
            images = factor.solve(mass @ block)
            block = mass_orthonormalize(images, mass, rank_tolerance=1e-12).vectors
        found = np.linalg.eigvalsh(block.T @ (stiffness @ block))
        wanted = _FROM_MODES * float(np.sqrt(abs(found).max(initial=0.0)))
        if 0.1 * wanted <= shift <= 10 * wanted or wanted < _FREE * shift:
            return SlowMotions(shift, factor, block)
        shift = wanted
    raise AccuracyError(
        "no shift was found at which the machine's linear equations can be solved: its stiffness spans too "
        "many orders of magnitude; reduce its bodies, or remove parts that are far stiffer than the rest"
    )


def _shifted(equations: SparseEquations, shift: float) -> BorderedFactor:
    matrix: Any = equations.stiffness + shift * equations.damping + shift**2 * equations.mass
    return bordered_factor(
        csr_array(matrix),
        equations.constraint,
        equations.interior,
        equations.damping_columns,
        shift * equations.damping_signs,
    )
