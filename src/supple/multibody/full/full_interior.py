"""One full body inside a step: its sparse equations, and their coupling to the frame and the interfaces."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import jax
import numpy as np
from scipy.sparse import csc_array, csr_array

from supple.algebra.rotation import rotation_right_jacobian
from supple.algebra.sparse_factor import SparseFactor, factorize_general
from supple.body.full_body import FullBody
from supple.machine import DeadForce
from supple.multibody.full.full_inertia import FullInertia, FullMotion, cross_matrices, cross_matrix

__all__ = ["FullInterior", "InteriorForces", "InteriorState", "prepare_interior"]


_right_jacobian = jax.jit(rotation_right_jacobian)
_law_value = jax.jit(lambda law, time: law(time))


class InteriorState(NamedTuple):
    """Motion of one full body: frame (global origin motion, body spin) and coordinates."""

    rotation: np.ndarray
    coordinates: np.ndarray
    rates: np.ndarray
    accelerations: np.ndarray
    spin: np.ndarray
    spin_rate: np.ndarray
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
    frame_gap: np.ndarray
    """`D q`, (6,)"""


class Elimination(NamedTuple):
    """What is left of the interior after its factorisation: `x = particular + responses @ unknowns`.

    `responses` answers to unit (generalised interface forces, frame accelerations, frame multipliers).
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
    """A factored tangent, what it was factored for, and its answers to interface forces and multipliers."""

    factor: SparseFactor
    velocity: float
    position: float
    spin: np.ndarray
    spin_rate: np.ndarray
    responses: np.ndarray
    """(n, 6 p + 6)"""

    def serves(self, motion: FullMotion, velocity: float, position: float) -> bool:
        """Whether Newton's iteration still converges fast with this tangent of a linear body."""
        same_step = np.isclose(velocity, self.velocity, rtol=1e-9) and np.isclose(
            position, self.position, rtol=1e-9, atol=0.0
        )
        turned = velocity * np.max(abs(motion.spin - self.spin))
        turned += position * np.max(abs(motion.spin_rate - self.spin_rate))
        return bool(same_step and turned <= LARGEST_TURN)


LARGEST_TURN = 0.02
"""Change of spin times step up to which a linear body's factor is kept: about Newton's contraction."""


@dataclass(eq=False)
class _FactorCache:
    """The last factored tangent of a linear body.

    It changes with the step and the spin alone, so that one factor serves many steps, and a solution costs a
    tenth of a factorisation. Newton's iteration ends at the same motion without it, to its tolerance.
    """

    _last: _Factored | None = field(default=None, init=False)

    def serving(self, motion: FullMotion, velocity: float, position: float) -> _Factored | None:
        """The last factor where it still serves."""
        last = self._last
        return last if last is not None and last.serves(motion, velocity, position) else None

    def keep(self, factored: _Factored) -> None:
        """Replace the last factor."""
        self._last = factored


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
    damping: csc_array
    pattern: csc_array
    constant: dict[str, np.ndarray]
    """Entries on the pattern of the constant matrices: kind to (number, nnz)."""
    tangent_places: np.ndarray
    """Where the entries of the nonlinear tangent stand in the pattern."""
    loads: tuple[DeadForce, ...]
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
            spin=state.spin,
            spin_rate=state.spin_rate,
            frame_acceleration=state.rotation.T @ state.acceleration,
        )

    def _internal_force(self, coordinates: np.ndarray) -> np.ndarray:
        return self.full.body.force.internal_force(coordinates)

    def _load_forces(self, state: InteriorState) -> list[tuple[np.ndarray, np.ndarray]]:
        """Nodes (k,) and forces (k, 3) in body components of every nodal load."""
        forces = []
        for load in self.loads:
            nodes = np.asarray(load.at, dtype=int)
            values = np.broadcast_to(np.asarray(_law_value(load.law, state.time)), (len(nodes), 3))
            forces.append((nodes, values @ state.rotation))
        return forces

    def forces(self, state: InteriorState) -> InteriorForces:
        """All terms of the body's own equations of motion."""
        body, rotation = self.full.body, state.rotation
        terms = self.inertia.terms(self._motion(state))
        inertia = np.concatenate(
            [rotation @ terms.frame[:3], terms.frame[3:], body.expansion.T @ terms.nodal.ravel()]
        )
        internal = np.concatenate(
            [np.zeros(6), self._internal_force(state.coordinates) + self.damping @ state.rates]
        )
        nodal = np.zeros_like(terms.nodal)
        moment = np.zeros(3)
        place = body.nodes + self._nodal(state.coordinates)[:, :3]
        for nodes, values in self._load_forces(state):
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

    def _stiffness_data(self, coordinates: np.ndarray) -> np.ndarray:
        if self.full.is_linear:
            return self.constant["stiffness"][0]
        data = np.zeros(self.pattern.nnz)
        data[self.tangent_places] = self.full.body.assembly.tangent(coordinates).data
        return data

    def eliminate(
        self,
        state: InteriorState,
        residual: np.ndarray,
        increment: np.ndarray,
        velocity: float,
        position: float,
    ) -> Elimination:
        """Factor the interior's tangent and solve for everything that acts on it.

        residual : (n,) unbalanced generalised forces; increment : (3,) of the frame's rotation in this step
        """
        motion = self._motion(state)
        factored = self._factored(motion, state.coordinates, velocity, position)
        columns, rows, corner = self._border(motion, state, increment, velocity, position)
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

    def _factored(
        self, motion: FullMotion, coordinates: np.ndarray, velocity: float, position: float
    ) -> _Factored:
        """The interior's tangent, factored; a linear body's is kept while it serves."""
        linear = self.full.is_linear
        if linear and (last := self._cache.serving(motion, velocity, position)) is not None:
            return last
        data = velocity * self.constant["damping"][0]
        if position:
            data = data + position * self._stiffness_data(coordinates)
        for kind, factors in FullInertia.weights(motion, velocity, position).items():
            data = data + factors @ self.constant[kind]
        factor = self._analysed.refactorize(self._matrix(data))
        constant = np.column_stack([self.interface_rows.T.toarray(), self.frame_rows.T])
        factored = _Factored(
            factor, velocity, position, motion.spin, motion.spin_rate, -factor.solve(constant)
        )
        if linear:
            self._cache.keep(factored)
        return factored

    def _border(
        self,
        motion: FullMotion,
        state: InteriorState,
        increment: np.ndarray,
        velocity: float,
        position: float,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Tangents with the frame, its force in global: columns (n, 6), rows (6, n), corner (6, 6)."""
        columns, rows, corner = self.inertia.border(motion, velocity, position)
        turn = position * np.asarray(_right_jacobian(increment))
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
        for nodes, values in self._load_forces(state):
            # In body components dead forces turn against the frame: df = f x dpsi.
            crosses = cross_matrices(values)
            np.add.at(by_node[:, :3, 3:], nodes, -crosses @ turn)
            np.add.at(row_by_node[3:, :, :3].swapaxes(0, 1), nodes, position * crosses)
            corner[3:, 3:] -= np.einsum("kij,kjl->il", cross_matrices(place[nodes]), crosses) @ turn

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


def prepare_interior(index: int, full: FullBody, loads: tuple[DeadForce, ...]) -> FullInterior:
    """Everything of a full body that does not change from step to step."""
    body = full.body
    inertia = FullInertia(body)
    none = csc_array(body.mass.shape)
    damping = none if full.damping is None else csc_array(full.damping.matrix(body.stiffness, body.mass))
    matrices: dict[str, list[Any]] = {
        **inertia.matrices,
        "stiffness": [csc_array(body.stiffness)],
        "damping": [damping],
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
        # Put where JAX computes once: the table of a long run is many megabytes.
        loads=tuple(replace(load, force=jax.device_put(load.law)) for load in loads),
    )
