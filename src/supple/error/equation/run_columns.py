"""The motion of a reduced run in few columns: those of its basis, and what follows them at rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.body import FlexibleBody, frame_projector
from supple.error.equation.products_of_run import few_instants, pair_products, weights_of_instants
from supple.integrate import FloatingMotion
from supple.reduction import Condensation, ReducedBody, ReductionBasis

__all__ = ["RunColumns", "run_columns"]

Array = NDArray[np.float64]

MOST_FOLLOWING = 12
ROUND_OFF = 1e-6
MOST_SAMPLES = 40
SMALLEST_PRODUCT = 1e-5
SMALLEST_FOLLOWING = 1e-3
"""Of the largest motion that follows: directions that move less are left to the error."""


@dataclass(frozen=True, eq=False)
class RunColumns:
    """Motion `q = V gamma + z(gamma)` of a run in M-orthonormal columns, the first r of which are V.

    vectors : (n, s)
    coordinates, rates, accelerations : (t, s)
    rigid : (t, 6)      by which the run's displacements differ from these: z rests at an interface there
    """

    vectors: Array
    coordinates: Array
    rates: Array
    accelerations: Array
    rigid: Array

    def at(self, rows: slice) -> RunColumns:
        """A part of the run."""
        parts = (self.coordinates, self.rates, self.accelerations, self.rigid)
        return RunColumns(self.vectors, *(each[rows] for each in parts))


def run_columns(
    body: FlexibleBody, reduced: ReducedBody, basis: ReductionBasis, motion: FloatingMotion
) -> RunColumns:
    """Columns and coordinates of a run of a reduced body.

    Where a condensed quartic tensor lets motion z outside the basis follow it, the run balances at
    V gamma + z: there its residual is small, and there the tangent is to be taken. The few directions that z
    takes along the run are appended; whatever they leave out is error like any other, for the error equation
    holds about any motion near the true one.
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
    # z is not M-orthogonal to V, from which it differs in energy alone.
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


def _leading(body: FlexibleBody, basis: ReductionBasis, fields: Array, moved: float) -> Array:
    """Leading directions of fields outside a basis, M-orthonormal; `moved` is the length of the motion.

    What is left of a field that the basis holds is round-off, and so is z itself where the basis is complete.
    """
    mass, known = body.mass, basis.vectors
    seen = frame_projector(body, basis.frame)

    def outside(x: Array) -> Array:
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
