"""A machine linearised about an equilibrium, in coordinates that its joints leave free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.machine import Spin, System
from supple.multibody.equations.control_linearization import LinearControl

__all__ = ["LinearMachine"]

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class LinearMachine:
    """Small motions `y` of a machine at rest, or turning steadily.

        M y'' + C y' + K y = N^T f + H z,        p = N y,        G N = 0
        z' = E_p y + E_v y' + E_z z

    `p` holds per body the translation and the rotation of its frame, in the frame's own axes, and its
    deformation coordinates; `N` spans the motions that the joints leave free, so that no constraint is left.
    Of a machine that turns, the axes turn along: C has the gyroscopic, K the centrifugal terms. `z` holds the
    states of the controllers, one after the other.

    system    : System          in its equilibrium
    spin      : Spin | None
    time      : float           of loads and laws
    mass, damping, stiffness : (k, k)
    basis     : N, (n, k)
    full_mass : (n, n)          of `p`, the joints' constraints not considered
    control   : LinearControl   H (k, c), E_p (c, k), E_v (c, k), E_z (c, c)
    """

    system: System
    spin: Spin | None
    time: float
    mass: Array
    damping: Array
    stiffness: Array
    basis: Array
    full_mass: Array
    control: LinearControl

    @property
    def size(self) -> int:
        """Number k of independent coordinates."""
        return len(self.mass)

    def coordinates_of(self, motions: np.ndarray) -> np.ndarray:
        """Independent coordinates (k, ..) of motions (n, ..), the nearest ones where these open joints."""
        return np.linalg.lstsq(self.basis, motions, rcond=None)[0]
