"""Interior of one full body in a step: its sparse equations, and their coupling to frame and interfaces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import jax
import numpy as np
from scipy.sparse import block_array, coo_array, csr_array

from supple.algebra.cross import cross_matrices, cross_matrix
from supple.algebra.jax_settings import on_program_release
from supple.algebra.rotation import rotation_right_jacobian
from supple.body.full_body import FullBody
from supple.equations.full_inertia import FullInertia, FullMotion
from supple.equations.nodal_load import (
    PreparedLoad,
    forces_by_places,
    forces_by_rotation,
    nodal_forces,
    prepared,
)
from supple.fem.strain_operator import StrainOperator, strain_operator
from supple.integrate import StepFactors
from supple.machine import NodalLoad
from supple.methods.floating.full.elimination import Elimination, elimination
from supple.methods.floating.full.full_damping import FullDamping, full_damping
from supple.methods.floating.full.full_state import InteriorState
from supple.methods.floating.full.full_tangent import Factored, FullTangent, full_tangent

MOST_PREPARED = 4
"""Largest number of prepared bodies in the cache of a process."""

_right_jacobian = jax.jit(rotation_right_jacobian)
_forces = jax.jit(nodal_forces)
_forces_by_rotation = jax.jit(forces_by_rotation)
_forces_by_places = jax.jit(forces_by_places)


class InteriorForces(NamedTuple):
    """Terms of the equations of motion, frame part (6,) and coordinates (n,) joined, (6 + n,) each."""

    inertia: np.ndarray
    internal: np.ndarray
    applied: np.ndarray
    joint: np.ndarray
    """Force of the frame conditions alone."""
    frame_residual: np.ndarray
    """`D q`, (6,)"""


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
    strains: StrainOperator | None
    """None for a linear body"""
    damping: FullDamping
    tangent: FullTangent
    loads: tuple[tuple[np.ndarray, PreparedLoad], ...]
    """Nodes of each nodal load, and its arrays on the JAX device, copied once: load tables may be large"""

    def _nodal(self, coordinates: np.ndarray) -> np.ndarray:
        body = self.full.body
        return (body.expansion @ coordinates).reshape(len(body.nodes), body.dofs_per_node)

    def _motion(self, state: InteriorState) -> FullMotion:
        return FullMotion(
            coordinates=state.coordinates,
            rates=state.rates,
            accelerations=state.accelerations,
            angular_velocity=state.angular_velocity,
            angular_acceleration=state.angular_acceleration,
            frame_acceleration=state.rotation.T @ state.acceleration,
        )

    def _load_forces(
        self, state: InteriorState, place: np.ndarray
    ) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Nodes (k,) of every load, for nodes at `place` (N, 3); its forces (k, 3) in body components, and
        their derivative (k, 3, 3) by the frame's rotation.
        """
        for nodes, load in self.loads:
            at = load, place[nodes], state.rotation, state.time
            yield nodes, np.asarray(_forces(*at)), np.asarray(_forces_by_rotation(*at))

    def forces(self, state: InteriorState) -> InteriorForces:
        """All terms of the body's own equations of motion."""
        terms = self.inertia.terms(self._motion(state))
        inertia = np.concatenate([state.rotation @ terms.frame[:3], terms.frame[3:], terms.own])
        internal = np.concatenate([np.zeros(6), self._internal_force(state.coordinates, state.rates)])
        joint = np.concatenate([np.zeros(6), self.frame_rows.T @ state.frame_multipliers])
        applied = self._applied(state) if self.loads else np.zeros_like(joint)
        return InteriorForces(inertia, internal, applied, joint, self.frame_rows @ state.coordinates)

    def _applied(self, state: InteriorState) -> np.ndarray:
        """Minus the loads on nodes, on frame and coordinates (6 + n,)."""
        body, moved = self.full.body, self._nodal(state.coordinates)
        nodal, moment, place = np.zeros_like(moved), np.zeros(3), body.nodes + moved[:, :3]
        for nodes, values, _ in self._load_forces(state, place):
            np.add.at(nodal[:, :3], nodes, values)
            moment += np.cross(place[nodes], values).sum(axis=0)
        force = state.rotation @ nodal[:, :3].sum(axis=0)
        return -np.concatenate([force, moment, body.expansion.T @ nodal.ravel()])

    def _internal_force(self, coordinates: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Elastic and damping forces, (n,)."""
        damping = self.damping.force(rates)
        if self.strains is None:
            return self.full.body.force.internal_force(coordinates) + damping
        return self.strains.force(coordinates, rates, self.damping.retardation_time) + damping

    def eliminate(
        self, state: InteriorState, increment: np.ndarray, factors: StepFactors, factored: Factored
    ) -> Elimination:
        """The interior eliminated with its factored tangent, for any forces at frame and interfaces.

        increment : (3,) rotation of the frame in this step
        """
        columns, rows, corner = self._border(state, increment, factors)
        p = 6 * len(self.full.interfaces)
        constant = factored.responses
        responses = np.hstack([constant[:, :p], -factored.factor.solve(columns), constant[:, p:]])
        return elimination(factored.factor, responses, self.interface_rows, self.frame_rows, rows, corner)

    def linear_parts(self, state: InteriorState) -> tuple[csr_array, ...]:
        """`M`, `C` and `K` (6 + n, 6 + n) of a steadily rotating body, all in body axes."""
        borders = [
            self._border(state, np.zeros(3), StepFactors(*factors))
            for factors in ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0))
        ]
        still = borders[0]
        changes = [still, *(tuple(a - b for a, b in zip(own, still, strict=True)) for own in borders[1:])]
        following = self._following_loads(state)
        parts = []
        for number, ((columns, rows, corner), inner) in enumerate(
            zip(changes, self.tangent.linear_parts(state.coordinates, state.angular_velocity), strict=True)
        ):
            own = csr_array(block_array([[corner, rows], [columns, inner]], format="csr"))
            parts.append(own + following if number == 2 and following is not None else own)
        return tuple(parts)

    def _following_loads(self, state: InteriorState) -> csr_array | None:
        """Derivative (6 + n, 6 + n) of minus the loads that depend on the positions of their nodes."""
        body, d = self.full.body, self.full.body.dofs_per_node
        place = body.nodes + self._nodal(state.coordinates)[:, :3]
        entries, rows, columns = [], [], []
        for nodes, load in self.loads:
            if not load.follows_nodes:
                continue
            freedoms = d * nodes[np.asarray(load.facets)][:, :, None] + np.arange(3)
            change = np.asarray(_forces_by_places(load, place[nodes], state.rotation, state.time))
            entries.append(change.ravel())
            rows.append(np.broadcast_to(freedoms[..., None, None], change.shape).ravel())
            columns.append(np.broadcast_to(freedoms[:, None, None], change.shape).ravel())
        if not entries:
            return None
        joined = (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns)))
        by_nodes = csr_array(coo_array(joined, shape=(body.n_nodal, body.n_nodal)))
        # Nodal forces as forces and moments on the frame, and as generalised forces on the coordinates.
        frame = np.zeros((len(body.nodes), d, 6))
        frame[:, :3, :3] = np.eye(3)
        frame[:, :3, 3:] = -cross_matrices(place)
        on_freedoms = csr_array(block_array([[frame.reshape(-1, 6), body.expansion]], format="csr"))
        seen = csr_array(block_array([[csr_array((body.n_nodal, 6)), body.expansion]], format="csr"))
        return csr_array(-(on_freedoms.T @ by_nodes @ seen))

    def frame_mass(self, state: InteriorState) -> np.ndarray:
        """Mass matrix (6, 6) of the body in rigid motion: global translations, rotations in body axes."""
        corner = self.inertia.border(self._motion(state), StepFactors(0.0, 0.0)).corner.copy()
        corner[:, :3] = corner[:, :3] @ state.rotation.T
        corner[:3] = state.rotation @ corner[:3]
        return corner

    def kinetic_energy(self, state: InteriorState, velocity: np.ndarray) -> float:
        """Kinetic energy; `velocity` (3,) is that of the frame's origin, global."""
        momenta = self.inertia.momenta(
            state.coordinates[:, None],
            state.rates[:, None],
            state.angular_velocity[:, None],
            (state.rotation.T @ velocity)[:, None],
        )
        return float(momenta.kinetic[0])

    def _border(
        self, state: InteriorState, increment: np.ndarray, factors: StepFactors
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Tangents of the frame in body components: columns (n, 6), rows (6, n), corner (6, 6)."""
        motion = self._motion(state)
        columns, rows, corner = self.inertia.border(motion, factors)
        turn = factors.by_position * np.asarray(_right_jacobian(increment))
        frame_force = self.inertia.terms(motion).frame[:3]
        # With the frame's rotation dpsi, a = A^T (Rddot - g) changes by a x dpsi, and the force A p rotates.
        swing = cross_matrix(motion.frame_acceleration) @ turn
        columns, rows, corner = columns.copy(), rows.copy(), corner.copy()
        columns[:, 3:] += columns[:, :3] @ swing
        corner[:, 3:] += corner[:, :3] @ swing
        corner[:3, 3:] -= cross_matrix(frame_force) @ turn

        body = self.full.body
        d, place = body.dofs_per_node, body.nodes + self._nodal(state.coordinates)[:, :3]
        by_node = np.zeros((len(body.nodes), d, 6))
        row_by_node = np.zeros((6, len(body.nodes), d))
        for nodes, values, by_rotation in self._load_forces(state, place):
            # The derivative of forces by the displacements of their own nodes is neglected here.
            crosses = cross_matrices(values)
            np.add.at(by_node[:, :3, 3:], nodes, -by_rotation @ turn)
            np.add.at(row_by_node[3:, :, :3].swapaxes(0, 1), nodes, factors.by_position * crosses)
            corner[:3, 3:] -= (by_rotation - crosses).sum(axis=0) @ turn
            corner[3:, 3:] -= np.einsum("kij,kjl->il", cross_matrices(place[nodes]), by_rotation) @ turn

        if self.loads:
            columns += body.expansion.T @ by_node.reshape(-1, 6)
            rows += (body.expansion.T @ row_by_node.reshape(6, -1).T).T
        return columns, rows, corner


def prepare_interior(index: int, full: FullBody, loads: tuple[NodalLoad, ...]) -> FullInterior:
    """The part of a full body that is constant over all steps."""
    return replace(
        _unloaded_interior(full),
        index=index,
        loads=tuple((load.nodes, jax.device_put(prepared(load))) for load in loads),
    )


@lru_cache(maxsize=MOST_PREPARED)
def _unloaded_interior(full: FullBody) -> FullInterior:
    """Interior of a body without loads; shared by equilibrium, self-correction and error estimate."""
    body = full.body
    inertia = FullInertia(body)
    damping = full_damping(full)
    interface_rows, frame_rows = full.interface_motions, full.frame.constraint(body)
    frame_rows = frame_rows / np.linalg.norm(frame_rows, axis=1, keepdims=True)
    couplings = np.column_stack([interface_rows.T.toarray(), frame_rows.T])
    return FullInterior(
        index=0,
        full=full,
        inertia=inertia,
        interface_rows=interface_rows,
        frame_rows=frame_rows,
        strains=None if body.is_linear else strain_operator(body.assembly),
        damping=damping,
        tangent=full_tangent(full, inertia, damping, couplings),
        loads=(),
    )


on_program_release(_unloaded_interior.cache_clear)
