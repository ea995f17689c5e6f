"""The motion of a reduced run in few columns: those of its basis, and directions of the condensed motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.body import FlexibleBody, frame_projector
from supple.error.equation.products_of_run import few_instants, pair_products, weights_of_instants
from supple.integrate import FloatingMotion
from supple.reduction import Condensation, ReducedBody, ReductionBasis

__all__ = ["MotionColumns", "RunColumns", "motion_columns", "run_columns"]


MOST_FOLLOWING = 12
"""Largest number of columns of the condensed motion z."""
ROUND_OFF = 1e-6
"""Ratio of a remainder to its field below which the remainder is round-off."""
MOST_SAMPLES = 40
"""Largest number of times at which z is sampled."""
SMALLEST_PRODUCT = 1e-5
"""Pivot of the products of coordinates, relative to the largest, below which no sample time is added."""
SMALLEST_FOLLOWING = 1e-3
"""Ratio to the largest condensed motion below which a direction has no column and counts as error."""


@dataclass(frozen=True, eq=False)
class RunColumns:
    """Motion `q = V gamma + z(gamma)` of a run in M-orthonormal columns, the first r of which are V.

    vectors : (n, s)
    coordinates, rates, accelerations : (t, s)
    rigid : (t, 6)      rigid motion that the displacements of the run contain in addition to z, so that their
                        condensed part is zero at the first interface
    """

    vectors: FloatArray
    coordinates: FloatArray
    rates: FloatArray
    accelerations: FloatArray
    rigid: FloatArray

    def at(self, rows: slice) -> RunColumns:
        """The rows of a part of the run."""
        parts = (self.coordinates, self.rates, self.accelerations, self.rigid)
        return RunColumns(self.vectors, *(each[rows] for each in parts))


def run_columns(
    body: FlexibleBody, reduced: ReducedBody, basis: ReductionBasis, motion: FloatingMotion
) -> RunColumns:
    """Columns and coordinates of a run of a reduced body.

    Where a condensed quartic tensor adds motion z outside the basis, the run is in balance at V gamma + z.
    Its residual is small there, and the tangent must be taken there. The few directions of z along the run
    are appended. The remainder of z counts as error, because the error equation holds about any motion near
    the true one.
    """
    gamma, rate, acceleration = (
        motion.coordinates,
        motion.coordinate_rates,
        motion.coordinate_accelerations,
    )
    own = (gamma, rate, acceleration)
    if reduced.condensed is None or not np.any(gamma):
        return RunColumns(basis.vectors, *own, rigid=np.zeros((len(gamma), 6)))
    scale = 1 / np.maximum(np.abs(gamma).max(axis=0), 1e-12 * np.abs(gamma).max())
    products = pair_products(gamma * scale, gamma * scale)
    chosen = few_instants(products, SMALLEST_PRODUCT, MOST_SAMPLES)
    condensation = Condensation(body, basis)
    sampled = condensation.bilinear(gamma[chosen], gamma[chosen])
    columns = np.hstack([basis.vectors, _leading(body, basis, sampled, float(np.linalg.norm(gamma[chosen])))])
    # z is not M-orthogonal to V; it is orthogonal in energy only.
    onto = columns.T @ (body.mass @ sampled)
    joined = []
    for given, wanted in zip(
        own,
        (
            products,
            2 * pair_products(gamma * scale, rate * scale),
            2 * pair_products(rate * scale, rate * scale)
            + 2 * pair_products(gamma * scale, acceleration * scale),
        ),
        strict=True,
    ):
        moved = weights_of_instants(products, chosen, wanted) @ onto.T
        moved[:, : basis.r] += given
        joined.append(moved)
    rigid = weights_of_instants(products, chosen, products) @ condensation.rigid_part(sampled).T
    return RunColumns(columns, *joined, rigid=rigid)


@dataclass(frozen=True, eq=False)
class MotionColumns:
    """Columns that contain the motion of all runs of a reduced body, the first r of which are V.

    vectors : (n, s)
    following : (s, r (r + 1) / 2)      coordinates of z in these columns, per pair of V's columns; None: no z
    rigid : (6, r (r + 1) / 2)          `RunColumns.rigid` per pair of V's columns; None: no z
    """

    vectors: FloatArray
    following: FloatArray | None = None
    rigid: FloatArray | None = None

    def along(self, motion: FloatingMotion) -> RunColumns:
        """The motion of a run in these columns."""
        gamma, rate, acceleration = (
            motion.coordinates,
            motion.coordinate_rates,
            motion.coordinate_accelerations,
        )
        if self.following is None or self.rigid is None:
            return RunColumns(self.vectors, gamma, rate, acceleration, np.zeros((len(gamma), 6)))
        products = pair_products(gamma, gamma)
        changes = (
            products,
            2 * pair_products(gamma, rate),
            2 * pair_products(rate, rate) + 2 * pair_products(gamma, acceleration),
        )
        moved = [change @ self.following.T for change in changes]
        for own, given in zip(moved, (gamma, rate, acceleration), strict=True):
            own[:, : gamma.shape[1]] += given
        return RunColumns(self.vectors, *moved, rigid=products @ self.rigid.T)


def motion_columns(
    body: FlexibleBody, reduced: ReducedBody, basis: ReductionBasis, coordinates: FloatArray
) -> MotionColumns:
    """The columns for all runs of a reduced body: V, and directions of z at some coordinates of these runs.

    coordinates : (t, r)    of these runs, at times that show the directions of z
    """
    if reduced.condensed is None or not np.any(coordinates):
        return MotionColumns(basis.vectors)
    first, second = np.triu_indices(basis.r)
    unit, counts = np.eye(basis.r), np.where(first == second, 1.0, 2.0)
    condensation = Condensation(body, basis)
    pairs = condensation.bilinear(unit[first], unit[second]) * counts
    chosen = np.unique(np.linspace(0, len(coordinates) - 1, MOST_SAMPLES).round().astype(int))
    some = coordinates[chosen]
    sampled = pairs @ pair_products(some, some).T
    columns = np.hstack([basis.vectors, _leading(body, basis, sampled, float(np.linalg.norm(some)))])
    return MotionColumns(columns, columns.T @ (body.mass @ pairs), condensation.rigid_part(pairs))


def _leading(body: FlexibleBody, basis: ReductionBasis, fields: FloatArray, moved: float) -> FloatArray:
    """Leading directions of fields outside a basis, M-orthonormal; `moved` is the size of the motion.

    The remainder of a field within the basis is round-off, and so is z itself for a complete basis.
    """
    mass, known = body.mass, basis.vectors
    seen = frame_projector(body, basis.frame)

    def outside(x: FloatArray) -> FloatArray:
        x = seen(x)
        return x - known @ (known.T @ (mass @ x))

    left = outside(outside(fields))
    squares, weights = np.linalg.eigh(left.T @ (mass @ left))
    lengths = np.sqrt(np.maximum(squares, 0.0))
    size = np.sqrt(np.sum(fields * (mass @ fields)))
    smallest = max(SMALLEST_FOLLOWING * lengths[-1], ROUND_OFF * size, ROUND_OFF**2 * moved)
    kept = np.flatnonzero(lengths > smallest)[::-1][:MOST_FOLLOWING]
    if not kept.size:
        return np.zeros((len(fields), 0))
    new = outside(left @ (weights[:, kept] / lengths[kept]))
    squares, weights = np.linalg.eigh(new.T @ (mass @ new))
    return new @ (weights / np.sqrt(squares))
