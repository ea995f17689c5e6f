"""Inertia of a full finite-element body in a floating frame: forces, momenta, and their tangents.

Lagrange's equations of the kinetic energy of `InertiaPolynomial`, which defines P_i, B_i, k_ij, Z_ij and J.
With the body's coordinates q, the momentum `S q'` of the rates, the first moment `s = s_0 + S q`, and the
frame's angular velocity w and acceleration a:

    coordinates  e = M q'' + w'_i (P_i + B_i^T q) + w_i (B_i^T - B_i) q' - w_i w_j (k_ij + Z_ij q) + S^T a
    force        p = P' + w x P,             P = w x s + S q',     P' = m a + w' x s + w x S q' + S q''
    moment       m = H' + w x H + s x a,     H = P_i . q' + q B_i q' + J(q) w

These forces do not depend on the velocity of the frame's origin; `momenta` do. The equations are those of
`floating_inertia` with V = I, for sparse matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array

from supple.algebra.cross import cross_matrix
from supple.body import FlexibleBody
from supple.body.inertia_polynomial import SPIN_PAIRS, InertiaPolynomial
from supple.integrate import StepFactors


class FullMotion(NamedTuple):
    """Coordinates of the body, their rates and accelerations (n,); motion of the frame (3,)."""

    coordinates: np.ndarray
    rates: np.ndarray
    accelerations: np.ndarray
    angular_velocity: np.ndarray
    angular_acceleration: np.ndarray
    frame_acceleration: np.ndarray
    """`A^T (Rddot - gravity)`"""


class FullInertiaForces(NamedTuple):
    """Inertia forces: on the coordinates (n,), on the frame (6,)."""

    own: np.ndarray
    frame: np.ndarray


class FullMomenta(NamedTuple):
    """Kinetic energy (t,), linear momentum (3, t), angular momentum about the frame's origin (3, t)."""

    kinetic: np.ndarray
    linear: np.ndarray
    angular: np.ndarray


class InertiaBorder(NamedTuple):
    """Tangents that involve the frame: columns (n, 6), rows (6, n), corner (6, 6)."""

    columns: np.ndarray
    rows: np.ndarray
    corner: np.ndarray


class _State(NamedTuple):
    """Quantities shared by force and tangent at one motion."""

    turned: np.ndarray
    """`B_i^T q`, (3, n)"""
    turned_rates: np.ndarray
    """`(B_i^T - B_i) q'`, (3, n)"""
    rates_turned: np.ndarray
    """`B_i q'`, (3, n)"""
    growth: np.ndarray
    """Derivative of `J_ij` with respect to q, (3, 3, n)"""
    inertia: np.ndarray
    """J(q), (3, 3)"""
    inertia_rate: np.ndarray
    """(3, 3)"""
    linear: np.ndarray
    """P, (3,)"""
    angular: np.ndarray
    """H, (3,)"""


@dataclass(frozen=True, eq=False)
class FullInertia:
    """The mass of a body, prepared for floating-frame inertia."""

    body: FlexibleBody

    @cached_property
    def _energy(self) -> InertiaPolynomial:
        return InertiaPolynomial(self.body)

    @cached_property
    def _rigid_momenta(self) -> np.ndarray:
        """`M R`, (n, 6): `S^T`, then `P_i`."""
        return self.body.mass @ self.body.rigid_modes

    @cached_property
    def _rigid(self) -> np.ndarray:
        """`R^T M R`, (6, 6)."""
        return self.body.rigid_modes.T @ self._rigid_momenta

    @cached_property
    def _growth_at_rest(self) -> np.ndarray:
        """`k_ij + k_ji`, (3, 3, n)."""
        return self._energy.by_both + self._energy.by_both.swapaxes(0, 1)

    def _of_pairs(self, fields: np.ndarray) -> np.ndarray:
        """`(Z_ij + Z_ji) q`, (3, 3, ...)."""
        products = self._energy.spin_products(fields)
        return products + products.swapaxes(0, 1)

    def _state(self, motion: FullMotion) -> _State:
        q, rates, w = motion.coordinates, motion.rates, motion.angular_velocity
        momenta = self._rigid_momenta.T
        turned, _ = self._energy.rate_products(q)
        rates_back, rates_turned = self._energy.rate_products(rates)
        growth = self._growth_at_rest + self._of_pairs(q)
        inertia = self._rigid[3:, 3:] + (self._growth_at_rest + growth) @ q / 2
        moving = momenta[:3] @ rates
        return _State(
            turned=turned,
            turned_rates=rates_back - rates_turned,
            rates_turned=rates_turned,
            growth=growth,
            inertia=inertia,
            inertia_rate=growth @ rates,
            linear=self._rigid[:3, 3:] @ w + cross_matrix(w) @ (momenta[:3] @ q) + moving,
            angular=(momenta[3:] + turned) @ rates + inertia @ w,
        )

    def terms(self, motion: FullMotion) -> FullInertiaForces:
        """Inertia forces on coordinates and frame."""
        state = self._state(motion)
        w, dw, a = motion.angular_velocity, motion.angular_acceleration, motion.frame_acceleration
        momenta, spin = self._rigid_momenta.T, cross_matrix(w)
        own = (
            self.body.mass @ motion.accelerations
            + dw @ (momenta[3:] + state.turned)
            + w @ state.turned_rates
            - np.einsum("i,ijn,j->n", w, state.growth, w) / 2
            + a @ momenta[:3]
        )
        moved, moving = momenta[:3] @ motion.coordinates, momenta[:3] @ motion.rates
        linear_rate = (
            self._rigid[:3, :3] @ a
            + self._rigid[:3, 3:] @ dw
            + cross_matrix(dw) @ moved
            + spin @ moving
            + momenta[:3] @ motion.accelerations
        )
        angular_rate = (
            (momenta[3:] + state.turned) @ motion.accelerations
            + state.rates_turned @ motion.rates
            + state.inertia @ dw
            + state.inertia_rate @ w
        )
        force = linear_rate + spin @ state.linear
        moment = angular_rate + spin @ state.angular + self._rigid[3:, :3] @ a + cross_matrix(moved) @ a
        return FullInertiaForces(own, np.concatenate([force, moment]))

    def momenta(
        self, coordinates: np.ndarray, rates: np.ndarray, angular_velocity: np.ndarray, velocity: np.ndarray
    ) -> FullMomenta:
        """Kinetic energy and momenta at t times.

        coordinates, rates : (n, t)
        angular_velocity, velocity : (3, t) of the frame, `w` and `v = A^T Rdot`
        """
        w, v, momenta = angular_velocity, velocity, self._rigid_momenta.T
        moved = momenta[:3] @ coordinates
        about_origin = self._rigid[:3, 3:] @ w + np.cross(w, moved, axis=0) + momenta[:3] @ rates
        turned, _ = self._energy.rate_products(coordinates)
        turning = momenta[3:] @ rates + np.einsum("int,nt->it", turned, rates)
        growth = self._growth_at_rest[..., None] + self._of_pairs(coordinates) / 2
        inertia = self._rigid[3:, 3:, None] + np.einsum("ijnt,nt->ijt", growth, coordinates)
        spun = np.einsum("ijt,jt->it", inertia, w)
        linear = self._rigid[:3, :3] @ v + about_origin
        own = np.einsum("nt,nt->t", rates, self.body.mass @ rates)
        kinetic = (np.sum(v * (linear + about_origin) + w * (spun + 2 * turning), axis=0) + own) / 2
        return FullMomenta(
            kinetic, linear, turning + spun + self._rigid[3:, :3] @ v + np.cross(moved, v, axis=0)
        )

    @property
    def mass(self) -> float:
        """Mass of the body."""
        return float(self._rigid[0, 0])

    def first_moment(self, coordinates: np.ndarray) -> np.ndarray:
        """`sum m (x + u)` in body components, (3, t), for coordinates (n, t).

        The sum of `m c`, from `Phi_t^T M Phi_w(0) = -(m c)~`, and of `Phi_t^T M q`.
        """
        turning = self._rigid[:3, 3:]
        rest = np.array([turning[1, 2], turning[2, 0], turning[0, 1]])
        return rest[:, None] + self._rigid_momenta[:, :3].T @ coordinates

    @cached_property
    def matrices(self) -> dict[str, list[csc_array]]:
        """Constant matrices (n, n) of the tangent's inertia part.

        mass `M`; gyroscopic `B_i^T - B_i`; euler `B_i^T`; centrifugal `-Z_ii` and `-(Z_ij + Z_ji)`, in the
        order of `SPIN_PAIRS`.
        """
        pairs = zip(SPIN_PAIRS, self._energy.by_spin, strict=True)
        return {
            "mass": [csc_array(self.body.mass)],
            "gyroscopic": [csc_array(matrix.T - matrix) for matrix in self._energy.by_rate],
            "euler": [csc_array(matrix.T) for matrix in self._energy.by_rate],
            "centrifugal": [-csc_array(Z if i == j else Z + Z.T) for (i, j), Z in pairs],
        }

    @staticmethod
    def weights(
        angular_velocity: np.ndarray, angular_acceleration: np.ndarray, factors: StepFactors
    ) -> dict[str, np.ndarray]:
        """Factors of `matrices` in the tangent."""
        first, second = np.transpose(SPIN_PAIRS)
        return {
            "mass": np.ones(1),
            "gyroscopic": factors.by_velocity * angular_velocity,
            "euler": factors.by_position * angular_acceleration,
            "centrifugal": factors.by_position * angular_velocity[first] * angular_velocity[second],
        }

    def border(self, motion: FullMotion, factors: StepFactors) -> InertiaBorder:
        """Tangents between the coordinates and the frame, with the same factors as `inertia_tangent`."""
        position, velocity = factors
        w, dw, a = motion.angular_velocity, motion.angular_acceleration, motion.frame_acceleration
        state, momenta = self._state(motion), self._rigid_momenta.T
        spin, change = cross_matrix(w), cross_matrix(dw)
        turning = momenta[3:] + state.turned
        spun = np.einsum("ijn,j->in", state.growth, w)
        columns = np.concatenate([momenta[:3], turning + velocity * (state.turned_rates - spun)]).T

        # Parts from H', from H, and from s x a.
        rate_rows = 2 * state.rates_turned + state.turned_rates
        place_rows = (
            self._energy.rate_products(motion.accelerations)[1]
            + np.einsum("ijn,j->in", state.growth, dw)
            + np.einsum("ijn,j->in", self._of_pairs(motion.rates), w)
        )
        momentum_rows = velocity * turning + position * (state.rates_turned + spun)
        moment_rows = turning + velocity * (rate_rows + spun) + position * place_rows
        moment_rows += spin @ momentum_rows - position * cross_matrix(a) @ momenta[:3]
        force_rows = (np.eye(3) + 2 * velocity * spin + position * (change + spin @ spin)) @ momenta[:3]

        moved = cross_matrix(momenta[:3] @ motion.coordinates)
        moving = cross_matrix(momenta[:3] @ motion.rates)
        arm = self._rigid[:3, 3:] - moved
        corner = np.block(
            [
                [
                    self._rigid[:3, :3],
                    arm + velocity * (spin @ arm - moving - cross_matrix(state.linear)),
                ],
                [
                    self._rigid[3:, :3] + moved,
                    state.inertia
                    + velocity * (state.inertia_rate + spin @ state.inertia - cross_matrix(state.angular)),
                ],
            ]
        )
        return InertiaBorder(columns, np.concatenate([force_rows, moment_rows]), corner)
