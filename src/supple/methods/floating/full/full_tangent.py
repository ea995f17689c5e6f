"""Tangent of a full body's own equations: its entries on one sparse pattern, and its factors.

With the step's factors `b'` by position and `g'` by velocity, the angular velocity `w` and its rate `dw`,

    S = M + g' (C + beta K_mat(q)) + b' K(q) + g' w_i G_i + b' (dw_i E_i - w_i w_j Z_ij)

Mass, stiffness, damping and centrifugal terms are symmetric, the gyroscopic terms `G_i` skew-symmetric, and
the terms `E_i` of the angular acceleration neither. The symmetric part has an L D L^T factor with a symbolic
analysis done once; the whole tangent needs an L U factor, two to three times the work.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array

from supple.algebra.low_rank_update import LowRankUpdate
from supple.algebra.sparse_factor import SparseFactor, factorize_general, factorize_symmetric
from supple.body.full_body import FullBody
from supple.equations.full_inertia import FullInertia
from supple.integrate import StepFactors
from supple.methods.floating.full.full_damping import FullDamping
from supple.methods.floating.full.full_state import InteriorState

LARGEST_TURN = 0.02
"""Largest `g' |change of w| + b' |change of dw|` for which the factor of a linear body is reused; Newton's
iteration then still converges fast."""

SYMMETRIC = ("mass", "euler", "centrifugal")
"""Inertia matrices with a symmetric part."""


class Factored(NamedTuple):
    """A factored tangent, and its responses to interface forces and multipliers."""

    factor: SparseFactor | LowRankUpdate
    responses: np.ndarray
    """(n, 6 p + 6)"""


@dataclass(eq=False)
class _LastFactor:
    """The last factored tangent of a linear body, at a state and step factors, as used by `serving`."""

    known: tuple[InteriorState, StepFactors, Factored] | None = None


@dataclass(frozen=True, eq=False)
class FullTangent:
    """The tangent of one full body; built by `full_tangent`."""

    full: FullBody
    damping: FullDamping
    pattern: csc_array
    """Symmetric."""
    constant: dict[str, np.ndarray]
    """Entries on the pattern of the constant matrices: kind to (number, nnz)."""
    elastic_places: np.ndarray
    """Places of the nonlinear stiffness's entries in the pattern."""
    couplings: np.ndarray
    """Loads of interface forces and frame multipliers, `[B^T, D^T]`, (n, 6 p + 6)"""
    _last: _LastFactor = field(default_factory=_LastFactor, init=False, repr=False)

    def linear_parts(self, coordinates: np.ndarray, angular_velocity: np.ndarray) -> tuple[csc_array, ...]:
        """`M`, `C` and `K` of the body in its steadily rotating frame: zero rates and accelerations."""
        weights = FullInertia.weights(angular_velocity, np.zeros(3), StepFactors(1.0, 1.0))
        mass, damping, stiffness = (
            self.constant[kind][0].copy() for kind in ("mass", "damping", "stiffness")
        )
        damping += weights["gyroscopic"] @ self.constant["gyroscopic"]
        if not self.full.is_linear:
            material, geometric = self.full.body.assembly.tangent_parts(coordinates)
            stiffness = np.zeros_like(stiffness)
            stiffness[self.elastic_places] = material.data + geometric.data
            damping[self.elastic_places] += self.damping.retardation_time * material.data
        stiffness += weights["centrifugal"] @ self.constant["centrifugal"]
        return self._matrix(mass), self._matrix(damping), self._matrix(stiffness)

    def exact(self, at: InteriorState, factors: StepFactors) -> Factored:
        """Factor of the unsymmetric tangent."""
        return self._factored(
            factors, factorize_general(self._matrix(self._data(at, factors, self.constant)))
        )

    def symmetric(self, at: InteriorState, factors: StepFactors) -> Factored:
        """Factor of the symmetric part of the tangent, on the existing symbolic analysis."""
        data = self._data(at, factors, self._symmetric_constant)
        return self._factored(factors, self._analysed.refactorize(self._matrix(data)))

    def serving(self, at: InteriorState, factors: StepFactors) -> Factored:
        """As `exact`, but the last factor of a linear body is reused while the iteration converges fast.

        Its tangent depends on the step, the angular velocity and its rate alone.
        """
        if not self.full.is_linear:
            return self.exact(at, factors)
        if self._last.known is not None:
            last, kept, factored = self._last.known
            same_step = np.isclose(factors.by_velocity, kept.by_velocity, rtol=1e-9) and np.isclose(
                factors.by_position, kept.by_position, rtol=1e-9, atol=0.0
            )
            turned = factors.by_velocity * np.max(abs(at.angular_velocity - last.angular_velocity))
            turned += factors.by_position * np.max(abs(at.angular_acceleration - last.angular_acceleration))
            if same_step and turned <= LARGEST_TURN:
                return factored
        factored = self.exact(at, factors)
        self._last.known = at, factors, factored
        return factored

    def _factored(self, factors: StepFactors, sparse: SparseFactor) -> Factored:
        factor = self.damping.with_modes(sparse, factors.by_velocity)
        return Factored(factor, -factor.solve(self.couplings))

    @cached_property
    def _analysed(self) -> SparseFactor:
        """Factor of the mass matrix on the pattern; its symbolic analysis is used for every tangent."""
        return factorize_symmetric(self._matrix(self.constant["mass"][0]))

    @cached_property
    def _symmetric_constant(self) -> dict[str, np.ndarray]:
        n = self.pattern.nnz
        transposed = csc_array(self._matrix(np.arange(n, dtype=float)).T)
        transposed.sort_indices()
        order = transposed.data.astype(np.int64)
        kept = {kind: self.constant[kind] for kind in (*SYMMETRIC, "stiffness", "damping")}
        return {kind: (entries + entries[:, order]) / 2 for kind, entries in kept.items()}

    def _data(self, at: InteriorState, factors: StepFactors, constant: dict[str, np.ndarray]) -> np.ndarray:
        """Entries of the tangent on the pattern, without the derivative of D(q)."""
        position, velocity = factors
        data = velocity * constant["damping"][0]
        if position and self.full.is_linear:
            data += position * constant["stiffness"][0]
        elif position:
            material = 1 + self.damping.retardation_time * velocity / position
            elastic = self.full.body.assembly.tangent(at.coordinates, material=material).data
            data[self.elastic_places] += position * elastic
        weights = FullInertia.weights(at.angular_velocity, at.angular_acceleration, factors)
        for kind, weight in weights.items():
            if kind in constant:
                data += weight @ constant[kind]
        return data

    def _matrix(self, data: np.ndarray) -> csc_array:
        return csc_array((data, self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape)


def full_tangent(
    full: FullBody, inertia: FullInertia, damping: FullDamping, couplings: np.ndarray
) -> FullTangent:
    """The part of a full body's tangent that is constant over all steps."""
    body = full.body
    matrices: dict[str, list[csc_array]] = {
        **inertia.matrices,
        "stiffness": [csc_array(body.stiffness)],
        "damping": [damping.constant],
    }
    elastic = csc_array(body.mass.shape)
    if not body.is_linear:
        assembly = body.assembly
        ones = np.ones(len(assembly.indices))
        elastic = csc_array((ones, assembly.indices, assembly.indptr), shape=body.mass.shape)
    # The nonlinear stiffness enters as ones, so that entries that are zero at rest keep their place.
    one_way = sum((abs(matrix) for group in matrices.values() for matrix in group), start=elastic)
    pattern = csc_array(one_way + one_way.T)
    pattern.sort_indices()
    columns = np.repeat(np.arange(body.n), np.diff(elastic.indptr))
    return FullTangent(
        full=full,
        damping=damping,
        pattern=pattern,
        constant={
            kind: np.array([_on_pattern(pattern, matrix) for matrix in group])
            for kind, group in matrices.items()
        },
        elastic_places=_places(pattern, elastic.indices, columns),
        couplings=couplings,
    )


def _on_pattern(pattern: csc_array, matrix: csc_array) -> np.ndarray:
    """Entries of a matrix at the places of a pattern that contains it."""
    data, coo = np.zeros(pattern.nnz), matrix.tocoo()
    np.add.at(data, _places(pattern, coo.row, coo.col), coo.data)
    return data


def _places(pattern: csc_array, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    n = len(pattern.indptr) - 1
    of_pattern = np.repeat(np.arange(n, dtype=np.int64), np.diff(pattern.indptr)) * n + pattern.indices
    return np.searchsorted(of_pattern, columns.astype(np.int64) * n + rows)
