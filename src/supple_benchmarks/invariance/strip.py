"""The strip of the invariance benchmark: thin steel without lateral contraction, clamped at one end."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from supple.errors import ConvergenceError
from supple.fem import (
    BeamSection,
    FiniteElementModel,
    HomogeneousSection,
    Isotropic,
    ShellSection,
    assemble,
    shell_model,
)
from supple.mesh import CellType, Mesh, strip
from supple_benchmarks.references.elastica import elastica

__all__ = [
    "BENDING",
    "LENGTH",
    "TORSION",
    "WARPING",
    "ClampedStrip",
    "beam_model",
    "force_for_rotation",
    "strip_mesh",
    "strip_model",
]

Array = NDArray[np.float64]

LENGTH, WIDTH, THICKNESS, MODULUS = 1.0, 0.1, 0.005, 2.1e11
BENDING = MODULUS * WIDTH * THICKNESS**3 / 12
"""E I, N m2"""
TORSION = MODULUS / 2 * WIDTH * THICKNESS**3 / 3
"""G J, N m2"""
WARPING = MODULUS * WIDTH**3 * THICKNESS**3 / 144
"""E Gamma of a thin rectangle, N m4"""
WALL = HomogeneousSection(Isotropic(MODULUS, 0.0, 7800.0), THICKNESS)


def strip_mesh(n_length: int = 20) -> Mesh:
    """Mesh of the strip, two cells wide."""
    return strip(LENGTH, WIDTH, n_length, 2)


def strip_model(n_length: int = 20) -> FiniteElementModel:
    """The strip as shells."""
    return shell_model(strip_mesh(n_length), WALL)


def beam_model(n_length: int) -> FiniteElementModel:
    """The strip as beams, high along y, so that z is the weak direction."""
    nodes = np.linspace(0, LENGTH, n_length + 1)[:, None] * np.eye(3)[0]
    cells = np.column_stack([np.arange(n_length), np.arange(1, n_length + 1)])
    sets = {"root": np.array([0]), "tip": np.array([n_length])}
    section = BeamSection(
        Isotropic(MODULUS, 0.0, 7800.0),
        WIDTH * THICKNESS,
        THICKNESS * WIDTH**3 / 12,
        BENDING / MODULUS,
        TORSION / (MODULUS / 2),
        5 / 6,
        5 / 6,
        orientation=(0, 1, 0),
    )
    return shell_model(Mesh(nodes, {CellType.LINE2: cells}, sets), section)


def force_for_rotation(bending: float, length: float, rotation: float) -> tuple[float, Array]:
    """Dead tip force for a given tip rotation of an elastica, N; position of the tip, along and across."""

    def missing(force: float) -> float:
        _, _, turned = elastica(bending, length, force)
        return turned - rotation

    scale = bending / length**2
    force = brentq(missing, 0.1 * scale, 20 * scale, xtol=1e-12 * scale)
    assert isinstance(force, float)
    return force, np.array(elastica(bending, length, force)[:2])


def rotated_rigidly(mesh: Mesh, motion: Array, around: Rotation) -> Array:
    """Nodal degrees of freedom (N, 6) of a motion followed by a rotation about the origin."""
    moved = around.apply(mesh.nodes + motion[:, :3]) - mesh.nodes
    return np.column_stack([moved, (around * Rotation.from_rotvec(motion[:, 3:])).as_rotvec()])


class ClampedStrip:
    """The strip with an exactly prescribed root, which may be rotated relative to the frame."""

    def __init__(self, n_length: int = 20, wall: ShellSection = WALL) -> None:
        self.mesh = strip_mesh(n_length)
        self.model = shell_model(self.mesh, wall)
        self.assembly = assemble(self.model)
        free = np.ones((self.mesh.n_nodes, 6), dtype=bool)
        free[self.mesh.nodes_of("root")] = False
        self.free = np.flatnonzero(free)

    def tip_force(self, force: ArrayLike) -> Array:
        """A dead force (3,) as (N, 6), distributed over the tip's nodes."""
        load = np.zeros((self.mesh.n_nodes, 6))
        load[self.mesh.nodes_of("tip"), :3] = np.outer([0.25, 0.5, 0.25], np.asarray(force))
        return load

    def tip_couple(self, torque: float) -> Array:
        """Two dead forces at the edges of the tip."""
        load = np.zeros((self.mesh.n_nodes, 6))
        load[self.mesh.nodes_of("tip")[[0, -1]], 2] = -torque / WIDTH, torque / WIDTH
        return load

    def tangent(self, motion: Array) -> csc_array:
        """Tangent of the degrees of freedom that are not prescribed."""
        return self.assembly.tangent(motion.ravel())[self.free][:, self.free]

    def bent(self, load: Array, steps: int = 3) -> Array:
        """Nodal degrees of freedom (N, 6) in equilibrium, with the root aligned to the frame."""
        return self._resting(load, np.zeros((self.mesh.n_nodes, 6)), steps)

    def seen_from(self, turn: ArrayLike, load: Array, motion: Array) -> Array:
        """The same equilibrium in a frame rotated relative to all bodies, in the axes of the root."""
        around = Rotation.from_rotvec(turn)
        turned_load = around.apply(load.reshape(-1, 3)).reshape(-1, 6)
        found = self._resting(turned_load, rotated_rigidly(self.mesh, motion, around), 1)
        return rotated_rigidly(self.mesh, found, around.inv())

    def energy(self, turn: Array, motion: Array) -> float:
        """Strain energy of a motion followed by a rotation, J."""
        turned = rotated_rigidly(self.mesh, motion, Rotation.from_rotvec(turn))
        return float(self.assembly.energy(turned.ravel()))

    def _resting(self, load: Array, start: Array, steps: int) -> Array:
        q = start.copy()
        for share in np.arange(1, steps + 1) / steps:
            for _ in range(30):
                residual = (share * load.ravel() - self.assembly.internal_force(q.ravel()))[self.free]
                change = splu(self.tangent(q)).solve(residual)
                q.reshape(-1)[self.free] += change
                if np.abs(change).max() < 1e-9:
                    break
            else:
                raise ConvergenceError(f"no equilibrium of the strip at {share:.2g} of its load")
        return q
