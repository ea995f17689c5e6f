"""One full body inside a step: its sparse equations, and their coupling to the frame and the interfaces."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import jax
import numpy as np
from scipy.sparse import csc_array, csr_array

from supple.algebra.cross import cross_matrices, cross_matrix
from supple.algebra.low_rank_update import LowRankUpdate
from supple.algebra.rotation import rotation_right_jacobian
from supple.algebra.sparse_factor import SparseFactor, factorize_general
from supple.body.full_body import FullBody
from supple.integrate import StepFactors
from supple.machine import NodalLoad
from supple.multibody.equations.nodal_load import (
    PreparedLoad,
    forces_by_rotation,
    nodal_forces,
    prepared,
)
from supple.multibody.full.full_damping import FullDamping, full_damping
from supple.multibody.full.full_inertia import FullInertia, FullMotion

__all__ = ["FullInterior", "InteriorForces", "InteriorState", "prepare_interior"]


_right_jacobian = jax.jit(rotation_right_jacobian)
_forces = jax.jit(nodal_forces)
_forces_by_rotation = jax.jit(forces_by_rotation)


class _LoadOnNodes(NamedTuple):
    """A nodal load, its numbers where JAX computes: the table of a long run is many megabytes."""

    nodes: np.ndarray
    prepared: PreparedLoad


class _LoadForces(NamedTuple):
    """Forces of a load on its nodes (k,), body components, and their change as the frame turns."""

    nodes: np.ndarray
    forces: np.ndarray
    """(k, 3)"""
    by_rotation: np.ndarray
    """(k, 3, 3)"""


class InteriorState(NamedTuple):
    """Motion of one full body: its frame, angular quantities in body components, and its coordinates."""

    rotation: np.ndarray
    coordinates: np.ndarray
    rates: np.ndarray
    accelerations: np.ndarray
    angular_velocity: np.ndarray
    angular_acceleration: np.ndarray
    acceleration: np.ndarray
    """Global acceleration of the frame origin minus gravity."""
    frame_multipliers: np.ndarray
    time: float


class InteriorForces(NamedTuple):
    """The terms in balance, frame part (6,) and coordinates (n,) joined, (6 + n,) each."""

    inertia: np.ndarray
    internal: np.ndarray
    applied: np.ndarray
    joint: np.ndarray
    """Of the frame conditions alone."""
    frame_residual: np.ndarray
    """`D q`, (6,)"""


class Elimination(NamedTuple):
    """What is left of the interior after its factorisation: `x = particular + responses @ unknowns`.

    The `unknowns` are generalised interface forces, frame accelerations and frame multipliers.
    """

    particular: np.ndarray
    """(n,)"""
    by_interface: np.ndarray
    """(n, 6 p)"""
    by_frame: np.ndarray
    """(n, 6)"""
    by_multiplier: np.ndarray
    """(n, 6)"""
    frame_rows: np.ndarray
    """Frame equations per interior acceleration, (6, n)"""
    frame_corner: np.ndarray
    """Frame equations per frame acceleration, (6, 6)"""


class _Factored(NamedTuple):
    """A factored tangent, what it was factored for, and its responses to interface forces and multipliers."""

    factor: SparseFactor | LowRankUpdate
    factors: StepFactors
    angular_velocity: np.ndarray
    angular_acceleration: np.ndarray
    responses: np.ndarray
    """(n, 6 p + 6)"""

    def serves(self, motion: FullMotion, factors: StepFactors) -> bool:
        """Whether Newton's iteration still converges fast with this tangent of a linear body."""
        by_position, by_velocity = factors
        same_step = np.isclose(by_velocity, self.factors.by_velocity, rtol=1e-9) and np.isclose(
            by_position, self.factors.by_position, rtol=1e-9, atol=0.0
        )
        turned = by_velocity * np.max(abs(motion.angular_velocity - self.angular_velocity))
        turned += by_position * np.max(abs(motion.angular_acceleration - self.angular_acceleration))
        return bool(same_step and turned <= LARGEST_TURN)


LARGEST_TURN = 0.02
"""Change of angular velocity times step up to which the factor is kept: about Newton's contraction."""


@dataclass(eq=False)
class _FactorCache:
    """The last factored tangent of a linear body.

    It changes with the step and the angular velocity alone, so that one factor serves many steps, and a
    solution costs a tenth of a factorisation. Newton's iteration ends at the same motion without
    it, to its tolerance.
    """

    _last: _Factored | None = field(default=None, init=False)

    def serving(self, motion: FullMotion, factors: StepFactors) -> _Factored | None:
        """The last factor where it still serves."""
        last = self._last
        return last if last is not None and last.serves(motion, factors) else None

    def keep(self, factored: _Factored) -> None:
        """Replace the last factor."""
        self._last = factored

    @property
    def last(self) -> _Factored | None:
        """The last factor, whether it serves or not."""
        return self._last


@dataclass(frozen=True, eq=False)
class FullInterior:
    """A full body prepared for stepping; built by `prepare_interior`."""

    index: int
    full: FullBody
    inertia: FullInertia
    interface_rows: csr_array
    """`B`, (6 p, n)"""
    frame_rows: np.ndarray
    """`D`, (6, n), scaled rows"""
    damping: FullDamping
    pattern: csc_array
    constant: dict[str, np.ndarray]
    """Entries on the pattern of the constant matrices: kind to (number, nnz)."""
    tangent_places: np.ndarray
    """Where the entries of the nonlinear tangent stand in the pattern."""
    loads: tuple[_LoadOnNodes, ...]
    _cache: _FactorCache = field(default_factory=_FactorCache, init=False, repr=False)
    """The only thing here that changes while stepping; it saves time alone."""

    def _nodal(self, coordinates: np.ndarray) -> np.ndarray:
        body = self.full.body
        return (body.expansion @ coordinates).reshape(len(body.nodes), body.dofs_per_node)

    def _motion(self, state: InteriorState) -> FullMotion:
        return FullMotion(
            displacement=self._nodal(state.coordinates),
            rate=self._nodal(state.rates),
            acceleration=self._nodal(state.accelerations),
            angular_velocity=state.angular_velocity,
            angular_acceleration=state.angular_acceleration,
            frame_acceleration=state.rotation.T @ state.acceleration,
        )

    def _load_forces(self, state: InteriorState, place: np.ndarray) -> list[_LoadForces]:
        """Of every nodal load, where the nodes are at `place` (N, 3)."""
        forces = []
        for load in self.loads:
            arguments = load.prepared, place[load.nodes], state.rotation, state.time
            forces.append(
                _LoadForces(
                    load.nodes, np.asarray(_forces(*arguments)), np.asarray(_forces_by_rotation(*arguments))
                )
            )
        return forces

    def forces(self, state: InteriorState) -> InteriorForces:
        """All terms of the body's own equations of motion."""
        body, rotation = self.full.body, state.rotation
        terms = self.inertia.terms(self._motion(state))
        inertia = np.concatenate(
            [rotation @ terms.frame[:3], terms.frame[3:], body.expansion.T @ terms.nodal.ravel()]
        )
        elastic = body.force.internal_force(state.coordinates)
        internal = np.concatenate([np.zeros(6), elastic + self.damping.force(state.coordinates, state.rates)])
        nodal = np.zeros_like(terms.nodal)
        moment = np.zeros(3)
        place = body.nodes + self._nodal(state.coordinates)[:, :3]
        for nodes, values, _ in self._load_forces(state, place):
            np.add.at(nodal[:, :3], nodes, values)
            moment += np.cross(place[nodes], values).sum(axis=0)
        applied = -np.concatenate(
            [rotation @ nodal[:, :3].sum(axis=0), moment, body.expansion.T @ nodal.ravel()]
        )
        joint = np.concatenate([np.zeros(6), self.frame_rows.T @ state.frame_multipliers])
        return InteriorForces(inertia, internal, applied, joint, self.frame_rows @ state.coordinates)

    def _matrix(self, data: np.ndarray) -> csc_array:
        return csc_array((data, self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape)

    @cached_property
    def _analysed(self) -> SparseFactor:
        """A factor of the mass matrix on the pattern, whose symbolic analysis serves every tangent."""
        return factorize_general(self._matrix(self.constant["mass"][0]))

    def _elastic_data(self, coordinates: np.ndarray, factors: StepFactors) -> np.ndarray:
        """Of the internal force and the damping by strain rate, but without the change of D(q) with q."""
        if self.full.is_linear:
            return factors.by_position * self.constant["stiffness"][0]
        material = 1 + self.damping.retardation_time * factors.by_velocity / factors.by_position
        data = np.zeros(self.pattern.nnz)
        data[self.tangent_places] = self.full.body.assembly.tangent(coordinates, material=material).data
        return factors.by_position * data

    def eliminate(
        self,
        state: InteriorState,
        residual: np.ndarray,
        increment: np.ndarray,
        factors: StepFactors,
    ) -> Elimination:
        """Factor the interior's tangent and solve for everything that acts on it.

        residual : (n,) unbalanced generalised forces; increment : (3,) of the frame's rotation in this step
        """
        motion = self._motion(state)
        factored = self._factored(motion, state.coordinates, factors)
        columns, rows, corner = self._border(motion, state, increment, factors)
        solved = -factored.factor.solve(np.column_stack([residual, columns]))
        p = 6 * len(self.full.interfaces)
        return Elimination(
            particular=solved[:, 0],
            by_interface=factored.responses[:, :p],
            by_frame=solved[:, 1:],
            by_multiplier=factored.responses[:, p:],
            frame_rows=rows,
            frame_corner=corner,
        )

    def _factored(self, motion: FullMotion, coordinates: np.ndarray, factors: StepFactors) -> _Factored:
        """The interior's tangent, factored; a linear body's is kept while it serves."""
        linear = self.full.is_linear
        if linear and (last := self._cache.serving(motion, factors)) is not None:
            return last
        factored = self._factor(motion.angular_velocity, motion.angular_acceleration, coordinates, factors)
        if linear:
            self._cache.keep(factored)
        return factored

    def _factor(
        self,
        angular_velocity: np.ndarray,
        angular_acceleration: np.ndarray,
        coordinates: np.ndarray,
        factors: StepFactors,
    ) -> _Factored:
        data = factors.by_velocity * self.constant["damping"][0]
        if factors.by_position:
            data = data + self._elastic_data(coordinates, factors)
        for kind, weight in FullInertia.weights(angular_velocity, angular_acceleration, factors).items():
            data = data + weight @ self.constant[kind]
        factor = self.damping.with_modes(self._analysed.refactorize(self._matrix(data)), factors.by_velocity)
        constant = np.column_stack([self.interface_rows.T.toarray(), self.frame_rows.T])
        return _Factored(factor, factors, angular_velocity, angular_acceleration, -factor.solve(constant))

    @property
    def factored_for(self) -> np.ndarray:
        """What the kept tangent was factored for, (8,): step factors, angular velocity, angular acceleration.

        NaN where none is kept. A run that goes on from here takes the same iterations with the same factor.
        """
        last = self._cache.last
        if last is None:
            return np.full(8, np.nan)
        return np.concatenate([last.factors, last.angular_velocity, last.angular_acceleration])

    def factor_again(self, factored_for: np.ndarray) -> None:
        """Factor what a recorded run had kept."""
        if np.isfinite(factored_for).all():
            factors = StepFactors(float(factored_for[0]), float(factored_for[1]))
            none = np.zeros(self.full.n_coordinates)
            self._cache.keep(self._factor(factored_for[2:5], factored_for[5:], none, factors))

    def frame_mass(self, state: InteriorState) -> np.ndarray:
        """Mass matrix of the body moving rigidly, for its frame's velocities, the first three global."""
        corner = self.inertia.border(self._motion(state), StepFactors(0.0, 0.0)).corner.copy()
        corner[:, :3] = corner[:, :3] @ state.rotation.T
        corner[:3] = state.rotation @ corner[:3]
        return corner

    def kinetic_energy(self, state: InteriorState, velocity: np.ndarray) -> float:
        """Kinetic energy; `velocity` (3,) is that of the frame's origin, global."""
        motion = self._motion(state)
        momenta = self.inertia.momenta(
            motion.displacement[..., None],
            motion.rate[..., None],
            state.angular_velocity[:, None],
            (state.rotation.T @ velocity)[:, None],
        )
        return float(momenta.kinetic[0])

    def _border(
        self,
        motion: FullMotion,
        state: InteriorState,
        increment: np.ndarray,
        factors: StepFactors,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Tangents with the frame, its force in global: columns (n, 6), rows (6, n), corner (6, 6)."""
        columns, rows, corner = self.inertia.border(motion, factors)
        turn = factors.by_position * np.asarray(_right_jacobian(increment))
        frame_force = self.inertia.terms(motion).frame[:3]
        # a = A^T (Rddot - g) changes with the frame's rotation, da = a x dpsi, and so does the force A p.
        swing = cross_matrix(motion.frame_acceleration) @ turn
        columns, rows, corner = columns.copy(), rows.copy(), corner.copy()
        columns[:, 3:] += columns[:, :3] @ swing
        corner[:, 3:] += corner[:, :3] @ swing
        corner[:3, 3:] -= cross_matrix(frame_force) @ turn

        d = self.full.body.dofs_per_node
        place = self.full.body.nodes + motion.displacement[:, :3]
        by_node = columns.reshape(-1, d, 6)
        row_by_node = rows.reshape(6, -1, d)
        for nodes, values, by_rotation in self._load_forces(state, place):
            # How forces follow the displacements of their own nodes is left to Newton's iteration.
            crosses = cross_matrices(values)
            np.add.at(by_node[:, :3, 3:], nodes, -by_rotation @ turn)
            np.add.at(row_by_node[3:, :, :3].swapaxes(0, 1), nodes, factors.by_position * crosses)
            corner[:3, 3:] -= (by_rotation - crosses).sum(axis=0) @ turn
            corner[3:, 3:] -= np.einsum("kij,kjl->il", cross_matrices(place[nodes]), by_rotation) @ turn

        rotation = state.rotation
        columns[:, :3] = columns[:, :3] @ rotation.T
        corner[:, :3] = corner[:, :3] @ rotation.T
        corner[:3] = rotation @ corner[:3]
        rows[:3] = rotation @ rows[:3]
        expansion = self.full.body.expansion
        return expansion.T @ columns, (expansion.T @ rows.T).T, corner


def _on_pattern(pattern: csc_array, matrix: csc_array) -> np.ndarray:
    """Entries of a matrix in the places of a pattern that contains it."""
    data = np.zeros(pattern.nnz)
    coo = matrix.tocoo()
    np.add.at(data, _places(pattern, coo.row, coo.col), coo.data)
    return data


def _places(pattern: csc_array, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    n = len(pattern.indptr) - 1
    of_pattern = np.repeat(np.arange(n, dtype=np.int64), np.diff(pattern.indptr)) * n + pattern.indices
    return np.searchsorted(of_pattern, columns.astype(np.int64) * n + rows)


def _unit_rows(rows: np.ndarray) -> np.ndarray:
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def prepare_interior(index: int, full: FullBody, loads: tuple[NodalLoad, ...]) -> FullInterior:
    """Everything of a full body that does not change from step to step."""
    body = full.body
    inertia = FullInertia(body)
    none = csc_array(body.mass.shape)
    damping = full_damping(full)
    matrices: dict[str, list[Any]] = {
        **inertia.matrices,
        "stiffness": [csc_array(body.stiffness)],
        "damping": [damping.constant],
    }
    pattern = sum((abs(matrix) for group in matrices.values() for matrix in group), start=none)
    shape = csc_array(body.mass.shape)
    if not body.is_linear:
        assembly = body.assembly
        ones = np.ones(len(assembly.indices))
        shape = csc_array((ones, assembly.indices, assembly.indptr), shape=body.mass.shape)
    # Added as ones, so that entries that happen to vanish at rest keep their place.
    pattern = csc_array(pattern + shape)
    pattern.sort_indices()
    columns = np.repeat(np.arange(body.n), np.diff(shape.indptr))
    return FullInterior(
        index=index,
        full=full,
        inertia=inertia,
        interface_rows=full.interface_motions,
        frame_rows=_unit_rows(full.frame.constraint(body)),
        damping=damping,
        pattern=pattern,
        constant={
            kind: np.array([_on_pattern(pattern, matrix) for matrix in group])
            for kind, group in matrices.items()
        },
        tangent_places=_places(pattern, shape.indices, columns),
        loads=tuple(_LoadOnNodes(load.nodes, jax.device_put(prepared(load))) for load in loads),
    )
