"""Stability of an equilibrium, from the signs of its tangent stiffness."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import scipy.linalg

from supple.algebra.bordered_factor import bordered_factor
from supple.equations.steady_motion import LinearEquations
from supple.errors import AccuracyError
from supple.methods.floating.full.linear_equations import SparseEquations
from supple.simulation.resting_state import RestingState

__all__ = ["is_stable"]

SKEW = 1e-6
"""Relative to the stiffness: a larger unsymmetric part is not rounding, but due to nonconservative forces."""
DISCRETE = 1e-2
"""The same for the coupling of two vibrations of intrinsic bodies. Part of it is a discretisation error of
the order of a segment's length squared: joints and loads act at points, whose velocities are not modal."""
ROUNDING = 1e-12
"""Relative to the largest eigenvalue."""


def is_stable(found: RestingState, time: float) -> bool | None:
    """Whether the tangent stiffness is positive on the motions that the joints leave free.

        p^T K p >= 0  for all  G p = 0

    K in co-rotating axes, with the centrifugal part. None if K does not decide: K is not symmetric, a
    controller acts, or gyroscopic forces may stabilise an even number of unstable directions.
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
    """Number of negative directions; None where the stiffness is not symmetric."""
    size = 1 / np.sqrt(np.diag(equations.mass))
    free = size[:, None] * scipy.linalg.null_space(equations.constraint * size)
    mass, stiffness = (free.T @ part @ free for part in (equations.mass, equations.stiffness))
    if not len(mass):
        return 0
    if _largest_coupling(mass, stiffness) > DISCRETE if discrete else _is_skew(stiffness):
        return None
    values = scipy.linalg.eigvalsh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
    return int(np.sum(values < -ROUNDING * abs(values).max()))


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


def _is_skew(stiffness: np.ndarray) -> bool:
    return bool(abs(stiffness - stiffness.T).max() > SKEW * abs(stiffness).max())
