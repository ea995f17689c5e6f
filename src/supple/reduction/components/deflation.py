"""Static response of the truncated modes to a load, by deflation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array

from supple.algebra import ConstrainedFactor, RitzModes

# Number of deflations; the relative round-off after two is that of one, squared.
DEFLATIONS = 2

# Ratio of residual to whole flexibility under a load, up to which the residual is round-off.
SMALLEST_RESIDUAL = 1e-12


class ResidualResponse(NamedTuple):
    """Static response of all truncated modes."""

    columns: np.ndarray
    """(n, k)  Y = F_r A, A the loads"""
    flexibility: np.ndarray
    """(k, k)  A^T F_r A = Y^T K Y"""
    mass: np.ndarray
    """(k, k)  Y^T M Y"""


def residual_response(
    solver: ConstrainedFactor, mass: csc_array, modes: RitzModes, loads: np.ndarray
) -> ResidualResponse:
    """Static response F_r A of the truncated modes, F_r = K^-1 - Phi Lambda^-1 Phi^T.

        A_r = A - M Phi Phi^T A,   Y = K^-1 A_r,   Y <- Y - Phi Phi^T M Y

    The kept modes are removed from the load before the solve and from the response after it, each twice. The
    difference K^-1 A - Phi Lambda^-1 Phi^T A would lose all digits if the modes contain nearly the whole
    response.

    solver : solves K x = b with the interfaces fixed, or in a mean-axis frame (inertia relief)
    modes : RitzModes       Phi, modes under the same constraints
    loads : (n, k)          A
    Source: [Han2020] (36) for its use; the deflation is derived here.
    """
    left = loads
    for _ in range(DEFLATIONS):
        left = left - mass @ modes.combine(modes.participation(left))
    columns = solver.solve(left)
    for _ in range(DEFLATIONS):
        columns = columns - modes.combine(modes.participation(mass @ columns))
    flexibility = left.T @ columns
    residual_mass = columns.T @ (mass @ columns)
    return ResidualResponse(
        columns, 0.5 * (flexibility + flexibility.T), 0.5 * (residual_mass + residual_mass.T)
    )


def residual_shares(flexibility: np.ndarray, participation: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Ratio (k,) of the residual flexibility to the whole flexibility, under each load; zero if both vanish.

    flexibility : (k, k)        of the residual
    participation : (m, k)      Phi^T A
    values : (m,)               Lambda
    """
    residual = np.diag(flexibility)
    whole = residual + np.sum(participation**2 / values[:, None], axis=0)
    return residual / np.where(whole > 0, whole, 1.0)
