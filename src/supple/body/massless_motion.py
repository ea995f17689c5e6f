"""Massless motions of a body: detection and static condensation.

With too few integration points, a consistent mass matrix is only positive semidefinite: with four points in a
ten-node tetrahedron, some motions of nodes of a single cell have no mass. If the stiffness is regular on
these motions Z (M Z = 0), static equilibrium ties them to the other freedoms:

    Z^T K u = 0,    u_e = - (Z^T K_e)^-1 Z^T K_k u_k,    u = T u_k

with the kept freedoms k, and as many eliminated freedoms e as Z has columns. T^T M T is positive definite,
and T maps the rigid motions of the kept freedoms to those of all freedoms.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

from supple.algebra import factorize_symmetric, lowest_modes
from supple.arrays import FloatArray, IntArray
from supple.errors import AccuracyError, ModelError

# The strain energy of a massless motion counts as zero up to this fraction of z^T diag(K) z; a pivot of the
# elimination counts as zero up to this fraction of the largest pivot.
_REGULAR = 1e-9
# Entries of u_e(u_k) below this fraction of the largest entry are set to zero.
_NO_TIE = 1e-11


def massless_motions(mass: sparse.csc_array, tolerance: float) -> FloatArray:
    """Motions Z (n, k) with M Z = 0, in the units of each freedom; k = 0 if M is positive definite.

    mass : M (n, n), with a positive diagonal
    tolerance : eigenvalues of M, scaled to a unit diagonal, count as zero if their absolute value is smaller
    Raises ModelError for an eigenvalue below minus the tolerance.
    """
    n = mass.indptr.size - 1
    try:
        inertia = factorize_symmetric(mass).inertia
    except AccuracyError:
        inertia = None
    if inertia is not None and inertia.positive == n:
        return np.zeros((n, 0))
    scale = 1.0 / np.sqrt(mass.diagonal())
    scaled = sparse.csc_array(mass.multiply(scale[:, None]).multiply(scale))
    unit = sparse.eye_array(n, format="csc")
    negative, none = (
        factorize_symmetric(scaled + shift * unit).inertia.negative for shift in (tolerance, -tolerance)
    )
    if negative:
        raise ModelError(f"{negative} negative and {none - negative} zero eigenvalues of {n}")
    lifted = sparse.csc_array(scaled + tolerance * unit)
    return scale[:, None] * lowest_modes(lifted, unit, none).vectors


class StaticallyTied(NamedTuple):
    """The numbers (m,) of the kept freedoms, and the expansion T (n, m) from them to all freedoms."""

    kept: IntArray
    expansion: sparse.csc_array


def tie_statically(
    stiffness: sparse.csc_array, motions: FloatArray, eligible: NDArray[np.bool_]
) -> StaticallyTied:
    """The kept freedoms and expansion after static condensation of the massless motions Z (n, k).

    eligible : (n,)     mask of freedoms that may be eliminated
    Raises ModelError for motions without stiffness, or motions that the eligible freedoms cannot represent.
    """
    n, k = motions.shape
    forces = motions.T @ stiffness
    # Energies z^T K z relative to z^T diag(K) z: zero for a motion without stiffness.
    alone = motions.T @ (stiffness.diagonal()[:, None] * motions)
    soft = int((linalg.eigvalsh(forces @ motions, alone) <= _REGULAR).sum())
    if soft:
        raise ModelError(f"{soft} of {k} motions without mass have no stiffness either")
    candidates = np.flatnonzero(eligible)
    by_own_stiffness = forces[:, candidates] / np.sqrt(stiffness.diagonal()[candidates])
    decomposed: tuple[Any, ...] = linalg.qr(by_own_stiffness, mode="r", pivoting=True)
    factor, order = decomposed[0], decomposed[-1]
    sizes = np.abs(np.diag(factor))
    if len(candidates) < k or sizes[k - 1] <= _REGULAR * sizes[0]:
        raise ModelError(f"{k} motions without mass cannot follow the freedoms beside them")
    eliminated = np.sort(candidates[order[:k]])
    kept = np.setdiff1d(np.arange(n), eliminated)
    ties = -np.linalg.solve(forces[:, eliminated], forces[:, kept])
    ties[np.abs(ties) < _NO_TIE * np.abs(ties).max()] = 0.0
    rows, columns = np.nonzero(ties)
    entries = np.concatenate([np.ones(len(kept)), ties[rows, columns]])
    places = np.concatenate([kept, eliminated[rows]]), np.concatenate([np.arange(len(kept)), columns])
    return StaticallyTied(kept, sparse.csc_array((entries, places), shape=(n, len(kept))))
