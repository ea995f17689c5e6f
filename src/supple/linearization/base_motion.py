"""Motion of the base of a machine: its acceleration as input, and the effective masses of modes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.errors import ModelError
from supple.linearization.linear_machine import Array, LinearMachine, rigid_motions
from supple.linearization.machine_modes import MachineModes
from supple.linearization.ports import checked_direction, direction_text

__all__ = ["BaseAccelerationPort", "effective_masses"]

EQUAL = 1e-6
"""Difference of two eigenvalues, relative to the larger, up to which they count as equal."""
DEPENDENT = 1e-9
"""Smallest eigenvalue of the products of unit shapes of equal frequency; smaller ones are rounding."""


@dataclass(frozen=True)
class BaseAccelerationPort:
    """Acceleration of the base along a direction, as input of a state space: a shaker, a launcher.

    The base is the ground of the machine. Motions and velocities of the outputs are relative to the base,
    their accelerations absolute, as with the load `BaseAcceleration`.

    direction : (3,)    global. Normalised.
    """

    direction: tuple[float, float, float]

    def __post_init__(self) -> None:
        direction = checked_direction("direction of the base's acceleration", self.direction)
        object.__setattr__(self, "direction", direction)

    @property
    def label(self) -> str:
        """Label of the base and the direction."""
        return f"acceleration of the base along {direction_text(self.direction)}"

    def row(self, machine: LinearMachine) -> Array:
        """`b = - r^T M N` (k,), inertia forces of a unit acceleration; r is the motion of all bodies."""
        return -(base_masses(machine)[:3].T @ self.direction)


def effective_masses(modes: MachineModes) -> Array:
    """Effective masses (k, 6) of modes for motions of the base.

        m_j = |phi^H M r_j|^2 / phi^H M phi

    for translations r_j along x, y, z (masses) and rotations about the global origin (moments of inertia).
    The sum over all modes is the mass that the joints do not hold to the base. The modes are those of an
    undamped machine, or of one with light damping. Shapes of equal frequency, whose choice is free, are made
    orthogonal first, so that their sum is determined.

    Raises ModelError for a rotating machine.
    """
    loads, values = base_masses(modes.machine) @ modes.independent, modes.eigenvalues
    products = modes.independent.conj().T @ modes.machine.mass @ modes.independent
    size = np.maximum(abs(values), abs(values)[:, None])
    products[abs(values - values[:, None]) > EQUAL * size] = 0.0
    found, vectors = np.linalg.eigh(products)
    # phi G^-1/2, with the products G = phi^H M phi: the nearest orthogonal shapes
    kept = found > DEPENDENT
    root = vectors[:, kept] / np.sqrt(found[kept]) @ vectors[:, kept].conj().T
    return abs(loads @ root).T ** 2


def base_masses(machine: LinearMachine) -> Array:
    """`r^T M N` (6, k) for three translations of all bodies and three rotations about the global origin."""
    if machine.spin is not None and machine.spin.rate:
        raise ModelError(
            "a base that moves has constant equations only in a machine that does not rotate: leave out spin"
        )
    pairs = zip(machine.slices, machine.system.bodies, strict=True)
    frames = ((own.start, placed.rotation, placed.position) for own, placed in pairs)
    return (machine.full_mass @ rigid_motions(len(machine.basis), frames)).T @ machine.basis
