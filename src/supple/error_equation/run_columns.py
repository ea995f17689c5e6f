"""The motion of a reduced run in few columns: those of its basis, and what follows them at rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from supple.body import FlexibleBody, frame_projector
from supple.integrate import FloatingMotion
from supple.reduction import ReducedBody, ReductionBasis
from supple.reduction.condensed_motion import CondensedMotion

__all__ = ["RunColumns", "run_columns"]

Array = NDArray[np.float64]

MOST_FOLLOWING = 12
SMALLEST_FOLLOWING = 1e-3
"""Of the largest motion that follows: directions that move less are left to the error."""


@dataclass(frozen=True, eq=False)
class RunColumns:
    """Motion `q = V gamma + z(gamma)` of a run in M-orthonormal columns, the first r of which are V.

    vectors : (n, s)
    coordinates, rates, accelerations : (t, s)
    r : int     number of columns of the basis; what is in the others, no displacement of the run shows
    """

    vectors: Array
    coordinates: Array
    rates: Array
    accelerations: Array
    r: int

    @property
    def unseen(self) -> Array:
        """Coordinates (t, s) of the motion that is in the strains of the run but not in its displacements."""
        hidden = self.coordinates.copy()
        hidden[:, : self.r] = 0.0
        return hidden


def run_columns(
    body: FlexibleBody, reduced: ReducedBody, basis: ReductionBasis, motion: FloatingMotion
) -> RunColumns:
    """Columns and coordinates of a run of a reduced body.

    Where a condensed quartic tensor lets motion z outside the basis follow it, the run balances at
    V gamma + z: there its residual is small, and there the tangent is to be taken. The few directions that z
    takes along the run are appended; whatever they leave out is error like any other, for the error equation
    holds about any motion near the true one.
    """
    gamma = motion.coordinates
    own = (gamma, motion.coordinate_rates, motion.coordinate_accelerations)
    if reduced.condensed is None or not np.any(gamma):
        return RunColumns(basis.vectors, *own, r=basis.r)
    amplitudes = _amplitudes(reduced.condensed, *own)
    added = _directions(body, basis, reduced.condensed, amplitudes[0])
    # P^T M z from the nodes: M = T^T M_nodal T and z_nodal = T z.
    onto = (body.nodal_mass @ (body.expansion @ added)).T @ reduced.condensed.fields
    joined = [np.hstack([given, each @ onto.T]) for given, each in zip(own, amplitudes, strict=True)]
    return RunColumns(np.hstack([basis.vectors, added]), *joined, r=basis.r)


def _amplitudes(condensed: CondensedMotion, gamma: Array, rate: Array, acceleration: Array) -> list[Array]:
    """Amplitudes (t, m) of the fields of z, of its rate 2 z(g, g') and of 2 z(g', g') + 2 z(g, g'')."""
    first, second = np.triu_indices(gamma.shape[1])

    def bilinear(a: Array, b: Array) -> Array:
        products = (a[:, first] * b[:, second] + b[:, first] * a[:, second]) / 2
        return products @ condensed.amplitudes.T

    return [
        bilinear(gamma, gamma),
        2 * bilinear(gamma, rate),
        2 * (bilinear(rate, rate) + bilinear(gamma, acceleration)),
    ]


def _directions(
    body: FlexibleBody, basis: ReductionBasis, condensed: CondensedMotion, amplitudes: Array
) -> Array:
    """Leading directions (n, p) of z along the run outside the basis, M-orthonormal, on D q = 0."""
    # Fields are orthonormal in the strain energy: leading in energy comes first, then length decides.
    _, _, rows = np.linalg.svd(amplitudes, full_matrices=False)
    rows = rows[: 2 * MOST_FOLLOWING]
    fields = _coordinates(body, condensed.fields @ rows.T)
    sizes = np.sqrt(np.mean((amplitudes @ rows.T) ** 2, axis=0))
    return _leading(body, basis, fields * sizes)


def _coordinates(body: FlexibleBody, nodal: Array) -> Array:
    """Coordinates q (n, m) of nodal fields T q."""
    T: Any = body.expansion
    return splu((T.T @ T).tocsc()).solve(np.ascontiguousarray(T.T @ nodal))


def _leading(body: FlexibleBody, basis: ReductionBasis, fields: Array) -> Array:
    mass, known = body.mass, basis.vectors
    seen = frame_projector(body, basis.frame)

    def outside(x: Array) -> Array:
        x = seen(x)
        return x - known @ (known.T @ (mass @ x))

    left = outside(outside(fields))
    squares, weights = np.linalg.eigh(left.T @ (mass @ left))
    lengths = np.sqrt(np.maximum(squares, 0.0))
    kept = np.flatnonzero(lengths > SMALLEST_FOLLOWING * lengths[-1])[::-1][:MOST_FOLLOWING]
    new = outside(left @ (weights[:, kept] / lengths[kept]))
    squares, weights = np.linalg.eigh(new.T @ (mass @ new))
    return new @ (weights / np.sqrt(squares))
