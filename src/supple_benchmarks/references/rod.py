"""A rod in space under loads at its tip, geometrically exact, by shooting: no elements.

    r' = R (e_x + Gamma),     R' = R K~,     m' = - r' x P

with the strains Gamma = C_N^-1 R^T P and K = K_0 + C_M^-1 R^T m; at the tip m is zero. The unknown is the
tip's rotation, from which the rod is integrated to its root, where the section must match the clamp.

Sources: S. S. Antman, Nonlinear Problems of Elasticity, chapter 8; J. C. Simo, Comput. Methods Appl. Mech.
Engrg. 49 (1985) 55-70.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

__all__ = ["Rod"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Rod:
    """A clamped rod along x, with its root at the origin and section axes parallel to the global ones.

    length : float
    stiffness (6,) : E A, G A along y and z, G J, E I about y and z
    curvature (3,) : unloaded, about the section's axes
    """

    length: float
    stiffness: ArrayLike
    curvature: ArrayLike = (0.0, 0.0, 0.0)

    def tip(self, force: ArrayLike, *, n_steps: int = 5) -> tuple[Array, Array]:
        """Position (3,) and rotation (3, 3) of the tip under a dead force, increased in steps."""
        turn, load = self._unloaded_tip(), np.zeros(3)
        for share in np.arange(1, n_steps + 1) / n_steps:
            load = share * np.asarray(force, dtype=float)
            before = turn

            def missed(step: Array, load=load, before=before) -> Array:
                at_root = self._shot(before @ Rotation.from_rotvec(step).as_matrix(), load)[1]
                return Rotation.from_matrix(at_root).as_rotvec()

            found, _, flag, message = fsolve(missed, np.zeros(3), xtol=1e-11, full_output=True)
            if flag != 1:
                raise RuntimeError(f"no equilibrium of the rod at {share:g} of its load: {message}")
            turn = before @ Rotation.from_rotvec(found).as_matrix()
        place, _ = self._shot(turn, load)
        return -place, turn

    def tip_followed(self, force: ArrayLike) -> tuple[Array, Array]:
        """Position and rotation of the tip under a follower force, by one integration from the tip."""
        place, turn = self._shot(np.eye(3), np.asarray(force, dtype=float))
        return -turn.T @ place, turn.T

    def _unloaded_tip(self) -> Array:
        return Rotation.from_rotvec(self.length * np.asarray(self.curvature, dtype=float)).as_matrix()

    def _shot(self, turn: Array, force: Array) -> tuple[Array, Array]:
        """Position and rotation of the root, from a tip at the origin."""
        stiffness, unloaded = np.asarray(self.stiffness, dtype=float), np.asarray(self.curvature, dtype=float)

        def rates(_: float, y: Array) -> Array:
            R, m = y[3:12].reshape(3, 3), y[12:]
            tangent = R @ (np.array([1.0, 0, 0]) + R.T @ force / stiffness[:3])
            K = unloaded + R.T @ m / stiffness[3:]
            skew = np.array([[0, -K[2], K[1]], [K[2], 0, -K[0]], [-K[1], K[0], 0]])
            return np.concatenate([tangent, (R @ skew).ravel(), -np.cross(tangent, force)])

        start = np.concatenate([np.zeros(3), turn.ravel(), np.zeros(3)])
        y = solve_ivp(rates, (self.length, 0.0), start, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
        return y[:3], y[3:12].reshape(3, 3)
