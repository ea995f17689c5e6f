"""Inertia of a full finite-element body in a floating frame: nodal forces, frame rows, and their tangents.

The same equations as `floating_inertia`, node by node instead of through a Gram matrix. With the nodal
velocities `V = Phi_w(q) w + qdot`, `h = M V` and `hdot = M (Phi_t a + Phi_w(q) wdot + w x qdot + qddot)`:

    node         y = hdot + w x h            (translations; no `w x` for rotations)
    force        p = sum y
    moment       m = sum (x + u) x y + V x h + sum_rot (hdot + w x h)

The velocity of the frame's origin drops out of these; `momenta` adds it to `V`.
Arrays over nodes have the shape (N, d, ...) with d = 3 or 6 freedoms a node, translations first.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_array, csr_array, eye_array, kron

from supple.algebra.cross import cross_matrices, cross_matrix
from supple.body import FlexibleBody
from supple.integrate import StepFactors

__all__ = [
    "FullInertia",
    "FullMomenta",
    "FullMotion",
    "InertiaBorder",
    "InertiaTerms",
]


class FullMotion(NamedTuple):
    """Displacements, velocities, accelerations (N, d) of the nodes; motion of the frame (3,)."""

    displacement: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    angular_velocity: np.ndarray
    angular_acceleration: np.ndarray
    frame_acceleration: np.ndarray
    """`A^T (Rddot - gravity)`"""


class InertiaTerms(NamedTuple):
    """Inertia forces: on nodes (N, d), on the frame (6,)."""

    nodal: np.ndarray
    frame: np.ndarray


class FullMomenta(NamedTuple):
    """Kinetic energy (t,), linear momentum (3, t), angular momentum about the frame's origin (3, t)."""

    kinetic: np.ndarray
    linear: np.ndarray
    angular: np.ndarray


class InertiaBorder(NamedTuple):
    """Tangents that involve the frame: columns (n_nodal, 6), rows (6, n_nodal), corner (6, 6)."""

    columns: np.ndarray
    rows: np.ndarray
    corner: np.ndarray


def _turned(fields: np.ndarray, w: np.ndarray) -> np.ndarray:
    """`w x field` on translations, zero on rotations; fields (N, d, ...)."""
    result = np.zeros_like(fields)
    result[:, :3] = np.einsum("ij,nj...->ni...", cross_matrix(w), fields[:, :3])
    return result


@dataclass(frozen=True, eq=False)
class FullInertia:
    """The mass matrix of a body, ready for floating-frame inertia."""

    body: FlexibleBody

    @property
    def _d(self) -> int:
        return self.body.dofs_per_node

    @cached_property
    def _mass(self) -> csr_array:
        return csr_array(self.body.nodal_mass)

    def _times_mass(self, fields: np.ndarray) -> np.ndarray:
        flat = fields.reshape(self.body.n_nodal, -1)
        return (self._mass @ flat).reshape(fields.shape)

    @cached_property
    def _translations(self) -> np.ndarray:
        """`Phi_t`, (N, d, 3)."""
        field = np.zeros((len(self.body.nodes), self._d, 3))
        field[:, :3] = np.eye(3)
        return field

    def _rotations(self, displacement: np.ndarray) -> np.ndarray:
        """`Phi_w(q)`, (N, d, 3): column j is `e_j x (x + u)`, and `e_j` on rotations."""
        field = np.zeros((len(self.body.nodes), self._d, 3))
        place = self.body.nodes + displacement[:, :3]
        field[:, :3] = -cross_matrices(place)
        if self._d == 6:
            field[:, 3:] = np.eye(3)
        return field

    def _momenta(self, motion: FullMotion) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Nodal velocities `V`, momenta `h` and their rate `hdot` in the frame, (N, d)."""
        rotations = self._rotations(motion.displacement)
        velocity = rotations @ motion.angular_velocity + motion.rate
        acceleration = (
            self._translations @ motion.frame_acceleration
            + rotations @ motion.angular_acceleration
            + _turned(motion.rate, motion.angular_velocity)
            + motion.acceleration
        )
        return velocity, self._times_mass(velocity), self._times_mass(acceleration)

    def terms(self, motion: FullMotion) -> InertiaTerms:
        """Inertia forces on nodes and frame."""
        velocity, momentum, rate = self._momenta(motion)
        nodal = rate + _turned(momentum, motion.angular_velocity)
        place = self.body.nodes + motion.displacement[:, :3]
        moment = (np.cross(place, nodal[:, :3]) + np.cross(velocity[:, :3], momentum[:, :3])).sum(axis=0)
        if self._d == 6:
            moment = moment + (nodal[:, 3:] + np.cross(motion.angular_velocity, momentum[:, 3:])).sum(axis=0)
        return InertiaTerms(nodal, np.concatenate([nodal[:, :3].sum(axis=0), moment]))

    def momenta(
        self, displacement: np.ndarray, rate: np.ndarray, angular_velocity: np.ndarray, velocity: np.ndarray
    ) -> FullMomenta:
        """Kinetic energy and momenta at t instants.

            V = Phi_t v + Phi_w(q) w + qdot,   h = M V,   T = V h / 2,   P = Phi_t^T h,   H = Phi_w(q)^T h

        displacement, rate : (N, d, t) of the nodes
        angular_velocity, velocity : (3, t) of the frame, `w` and `v = A^T Rdot`
        """
        place = self.body.nodes[:, :, None] + displacement[:, :3]
        fields = rate.copy()
        fields[:, :3] += velocity + np.cross(angular_velocity[None], place, axis=1)
        if self._d == 6:
            fields[:, 3:] += angular_velocity
        momentum = self._times_mass(fields)
        angular = np.cross(place, momentum[:, :3], axis=1).sum(axis=0)
        if self._d == 6:
            angular += momentum[:, 3:].sum(axis=0)
        return FullMomenta(
            np.einsum("ndt,ndt->t", fields, momentum) / 2, momentum[:, :3].sum(axis=0), angular
        )

    @cached_property
    def _mass_translations(self) -> np.ndarray:
        """`M Phi_t`, (N, d, 3)."""
        return self._times_mass(self._translations)

    @property
    def mass(self) -> float:
        """Mass of the body, kg."""
        return float(self._mass_translations[:, 0, 0].sum())

    def first_moment(self, displacement: np.ndarray) -> np.ndarray:
        """`sum m (x + u)` in body components, (3, t), for displacements (N, d, t).

        At rest from `Phi_t^T M Phi_w(0) = -(m c)~`, in motion with `Phi_t^T M q`, whose rate is momentum.
        """
        weights = self._mass_translations
        at_rest = np.zeros((len(self.body.nodes), self._d))
        turning = np.einsum("nda,ndb->ab", weights, self._rotations(at_rest))
        rest = np.array([turning[1, 2], turning[2, 0], turning[0, 1]])
        return rest[:, None] + np.einsum("nda,ndt->at", weights, displacement)

    @cached_property
    def _axis_turns(self) -> tuple[csr_array, ...]:
        """`E_i`: the sparse matrices of `e_i x` on the translations of all nodes."""
        per_node = []
        for axis in np.eye(3):
            block = np.zeros((self._d, self._d))
            block[:3, :3] = cross_matrix(axis)
            per_node.append(csr_array(kron(eye_array(len(self.body.nodes)), csr_array(block))))
        return tuple(per_node)

    @cached_property
    def matrices(self) -> dict[str, list[csc_array]]:
        """Constant matrices (n, n), in the body's coordinates, of the tangent's inertia part.

        mass `M`; gyroscopic `M E_i + E_i M`; euler `M E_i`; centrifugal `E_i M E_j + E_j M E_i` (i < j),
        `E_i M E_i`, in the order 11, 22, 33, 12, 13, 23.
        """
        mass, turns, expand = self._mass, self._axis_turns, self.body.expansion

        def project(matrix: Any) -> csc_array:
            return csc_array(expand.T @ matrix @ expand)

        pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
        return {
            "mass": [project(mass)],
            "gyroscopic": [project(mass @ e + e @ mass) for e in turns],
            "euler": [project(mass @ e) for e in turns],
            "centrifugal": [
                project(turns[i] @ mass @ turns[j] + (turns[j] @ mass @ turns[i] if i != j else 0 * mass))
                for i, j in pairs
            ],
        }

    @staticmethod
    def weights(
        angular_velocity: np.ndarray, angular_acceleration: np.ndarray, factors: StepFactors
    ) -> dict[str, np.ndarray]:
        """Factors of `matrices` in the tangent."""
        x, y, z = angular_velocity
        return {
            "mass": np.ones(1),
            "gyroscopic": factors.by_velocity * angular_velocity,
            "euler": factors.by_position * angular_acceleration,
            "centrifugal": factors.by_position * np.array([x * x, y * y, z * z, x * y, x * z, y * z]),
        }

    def border(self, motion: FullMotion, factors: StepFactors) -> InertiaBorder:
        """Tangents between the nodes and the frame, for the same factors as `inertia_tangent`."""
        position, velocity = factors
        w, dw = motion.angular_velocity, motion.angular_acceleration
        rotations = self._rotations(motion.displacement)
        _, momentum, rate = self._momenta(motion)
        mass_translations = self._mass_translations
        mass_rotations = self._times_mass(rotations)
        axes = np.eye(3)

        by_rotation_rate = np.stack([_turned(motion.rate, axis) for axis in axes], axis=-1)
        turned_momentum = np.stack([_turned(momentum, axis) for axis in axes], axis=-1)
        columns_rotation = mass_rotations + velocity * (
            self._times_mass(by_rotation_rate) + turned_momentum + _turned(mass_rotations, w)
        )
        columns = np.concatenate([mass_translations, columns_rotation], axis=-1)

        left = np.concatenate([self._translations, rotations], axis=-1)
        mass_left = np.concatenate([mass_translations, mass_rotations], axis=-1)
        # (L^T w~) M: for a column l of L, (w~)^T l = -w x l
        mass_turned_left = self._times_mass(-_turned(left, w))
        rows = (
            mass_left
            - velocity * _turned(mass_left, w)
            - position * _turned(mass_left, dw)
            + velocity * mass_turned_left
            - position * _turned(mass_turned_left, w)
        )
        nodal = rate + _turned(momentum, w)
        # dX x y seen along e_j: dX . (y x e_j)
        arm_change = np.zeros_like(rotations)
        arm_change[:, :3] = -np.einsum("jab,nb->naj", np.array([cross_matrix(e) for e in axes]), nodal[:, :3])
        rows[..., 3:] += position * arm_change
        corner = np.einsum("nda,ndb->ab", left, columns)
        if self._d == 6:
            # e_j . (w x dh_rot) = (e_j x w) . dh_rot
            spun = np.zeros_like(rotations)
            spun[:, 3:] = np.cross(axes, w).T
            mass_spun = self._times_mass(spun)
            rows[..., 3:] += velocity * mass_spun - position * _turned(mass_spun, w)
            total = momentum[:, 3:].sum(axis=0)
            change = velocity * mass_rotations[:, 3:].sum(axis=0)
            corner[3:, 3:] += cross_matrix(w) @ change - velocity * cross_matrix(total)
        n_nodal = self.body.n_nodal
        return InertiaBorder(columns.reshape(n_nodal, 6), rows.reshape(n_nodal, 6).T, corner)
