"""Stability of an equilibrium, from the signs of its tangent stiffness."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array

from supple.algebra.bordered_factor import bordered_factor
from supple.equations.steady_motion import LinearEquations
from supple.errors import AccuracyError
from supple.methods.floating.full.linear_equations import SparseEquations
from supple.simulation.resting_state import RestingState

SKEW = 1e-6
"""Largest unsymmetric part of the stiffness attributed to rounding, relative to the largest entry of the
stiffness; a larger part is due to nonconservative forces, and stability is not decided."""
DISCRETE = 1e-2
"""Like `SKEW`, for the coupling of two vibrations of intrinsic bodies, relative to their mean stiffness. Part
of the coupling is a discretisation error of the order of a segment length squared: joints and loads act at
points, whose velocities are not modal."""
ROUNDING = 1e-12
"""Eigenvalues of smaller magnitude, relative to the largest eigenvalue, count as zero."""


def is_stable(found: RestingState, time: float) -> bool | None:
    """Whether the tangent stiffness has no negative eigenvalue on the motions that the joints leave free.

        p^T K p >= 0  for all  G p = 0

    K is the stiffness in co-rotating axes, with the centrifugal part. None if K does not decide: K is not
    symmetric or cannot be factored, a controller acts, or gyroscopic forces may stabilise an even number of
    unstable directions.
    Source: Lagrange and Dirichlet; Kelvin and Tait for the spin.
    """
    if found.system.controllers:
        return None
    equations = found.equations.linear_equations(found.state, time)
    if isinstance(equations, SparseEquations):
        falling = _falling_sparse(equations)
    else:
        falling = _falling(equations, discrete=found.equations.is_discrete)
    if falling is None:
        return None
    spins = bool(np.any(found.turning.angular_velocities))
    return None if spins and falling and falling % 2 == 0 else falling == 0


def _falling(equations: LinearEquations, *, discrete: bool) -> int | None:
    """Number of negative eigenvalues of the stiffness; None if the stiffness is not symmetric."""
    free = free_motions(equations)
    mass, stiffness = (free.T @ part @ free for part in (equations.mass, equations.stiffness))
    if not len(mass):
        return 0
    if _largest_coupling(mass, stiffness) > DISCRETE if discrete else _is_skew(stiffness):
        return None
    values = scipy.linalg.eigvalsh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
    return int(np.sum(values < -ROUNDING * abs(values).max()))


def free_motions(equations: LinearEquations) -> np.ndarray:
    """Basis `N` (n, k) of the null space of `G`; each column has unit kinetic energy."""
    size = 1 / np.sqrt(np.diag(equations.mass))
    return size[:, None] * scipy.linalg.null_space(equations.constraint * size)


def _falling_sparse(equations: SparseEquations) -> int | None:
    stiffness = equations.stiffness
    if _is_skew(stiffness):
        return None
    symmetric = (stiffness + stiffness.T) / 2
    # A motion without stiffness makes the matrix singular; a shift within rounding makes it positive.
    squares = abs(symmetric.diagonal()) / equations.mass.diagonal()
    for shift in (0.0, ROUNDING * float(squares[np.isfinite(squares)].max(initial=0.0))):
        with suppress(AccuracyError):
            matrix = symmetric + shift * equations.mass
            factor = bordered_factor(matrix, equations.constraint, equations.interior)
            return factor.negative - equations.constraint.shape[0]
    return None


def _largest_coupling(mass: np.ndarray, stiffness: np.ndarray) -> float:
    """Largest unsymmetric coupling of two modes of the symmetric part, relative to their mean stiffness."""
    values, motions = scipy.linalg.eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
    coupling = abs(motions.T @ (stiffness - stiffness.T) @ motions) / 2
    size = abs(values)[:, None] + abs(values)
    return float((coupling / np.where(size > ROUNDING * size.max(), size, np.inf)).max())


def _is_skew(stiffness: np.ndarray | csr_array) -> bool:
    return bool(abs(stiffness - stiffness.T).max() > SKEW * abs(stiffness).max())
