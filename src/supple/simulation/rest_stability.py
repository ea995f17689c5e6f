"""Whether an equilibrium is stable: the signs of its tangent stiffness."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from supple.algebra.bordered_factor import bordered_factor
from supple.body import FullBody
from supple.methods.intrinsic.line_statics import LineStatics
from supple.simulation.resting_state import RestingState

__all__ = ["is_stable"]

SKEW = 1e-6
"""Of a stiffness: a larger unsymmetric part is no rounding, but of forces that do not have a potential."""
DISCRETE = 1e-2
"""The same of intrinsic bodies, between two vibrations: the velocities of places, on which joints and loads
act, and of modes differ by the square of a segment's length."""
ROUNDING = 1e-12
"""Of the largest eigenvalue."""


def is_stable(found: RestingState, time: float) -> bool | None:
    """Whether the tangent stiffness is positive on the motions that the joints leave free.

        p^T K p >= 0  for all  G p = 0

    K in axes that turn along, with the centrifugal part. None where it does not decide: K is not symmetric,
    a controller acts, or a spin may hold an even number of directions of fall by gyroscopic forces.
    Source: Lagrange and Dirichlet; Kelvin and Tait for the spin.
    """
    if found.system.controllers:
        return None
    falling = _falling_in_full(found, time) if found.system.bodies_of(FullBody) else _falling(found, time)
    if falling is None:
        return None
    spins = bool(np.any(found.turning.angular_velocities))
    return None if spins and falling and falling % 2 == 0 else falling == 0


def _falling(found: RestingState, time: float) -> int | None:
    """Number of negative directions; None where the stiffness is not symmetric."""
    equations = found.machine.linear_equations(found.state, time)
    size = 1 / np.sqrt(np.diag(equations.mass))
    free = size[:, None] * scipy.linalg.null_space(equations.jacobian * size)
    mass, stiffness = (free.T @ part @ free for part in (equations.mass, equations.stiffness))
    if not len(mass):
        return 0
    if isinstance(found.machine, LineStatics):
        skew = _largest_coupling(mass, stiffness) > DISCRETE
    else:
        skew = _is_skew(stiffness)
    if skew:
        return None
    values = scipy.linalg.eigvalsh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
    return int(np.sum(values < -ROUNDING * abs(values).max()))


def _falling_in_full(found: RestingState, time: float) -> int | None:
    equations = found.machine.linear_equations(found.state, time)
    stiffness = equations.stiffness
    if _is_skew(stiffness):
        return None
    symmetric = (stiffness + stiffness.T) / 2
    factor = bordered_factor(symmetric, equations.constraint, equations.interior)
    return factor.negative - equations.constraint.shape[0]


def _largest_coupling(mass: np.ndarray, stiffness: np.ndarray) -> float:
    """Unsymmetric part between vibrations of the symmetric one, over the mean of their stiffnesses."""
    values, motions = scipy.linalg.eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
    coupling = abs(motions.T @ (stiffness - stiffness.T) @ motions) / 2
    size = abs(values)[:, None] + abs(values)
    return float((coupling / np.where(size > ROUNDING * size.max(), size, np.inf)).max())


def _is_skew(stiffness: np.ndarray) -> bool:
    return bool(abs(stiffness - stiffness.T).max() > SKEW * abs(stiffness).max())
