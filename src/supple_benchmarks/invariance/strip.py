"""The strip of the invariance benchmark: thin steel with Poisson's ratio 0, clamped at one end."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
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
from supple.mesh import Mesh, strip
from supple_benchmarks.lines import line_mesh, points_along_x

__all__ = [
    "BENDING",
    "LENGTH",
    "TORSION",
    "WARPING",
    "ClampedStrip",
    "beam_model",
    "strip_mesh",
    "strip_model",
]

Array = NDArray[np.float64]

LENGTH, WIDTH, THICKNESS, MODULUS = 1.0, 0.1, 0.005, 2.1e11
BENDING = MODULUS * WIDTH * THICKNESS**3 / 12
"""Bending stiffness E I, N m2."""
TORSION = MODULUS / 2 * WIDTH * THICKNESS**3 / 3
"""Torsional stiffness G J, N m2."""
WARPING = MODULUS * WIDTH**3 * THICKNESS**3 / 144
"""Warping stiffness E Gamma of a thin rectangle, N m4."""
WALL = HomogeneousSection(Isotropic(MODULUS, 0.0, 7800.0), THICKNESS)


def strip_mesh(n_length: int = 20) -> Mesh:
    """Mesh of the strip, two cells wide."""
    return strip(LENGTH, WIDTH, n_length, 2)


def strip_model(n_length: int = 20) -> FiniteElementModel:
    """The strip as shell elements."""
    return shell_model(strip_mesh(n_length), WALL)


def beam_model(n_length: int) -> FiniteElementModel:
    """The strip as beam elements along x, whose section is wide along y and thin along z."""
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
    return shell_model(line_mesh(points_along_x(LENGTH, n_length)), section)


def rotated_rigidly(mesh: Mesh, motion: Array, around: Rotation) -> Array:
    """Nodal freedoms (N, 6) of the motion followed by a rigid rotation about the origin."""
    moved = around.apply(mesh.nodes + motion[:, :3]) - mesh.nodes
    return np.column_stack([moved, (around * Rotation.from_rotvec(motion[:, 3:])).as_rotvec()])


class ClampedStrip:
    """The strip with prescribed motion of its root nodes; the root may be rotated relative to the frame."""

    def __init__(self, n_length: int = 20, wall: ShellSection = WALL) -> None:
        self.mesh = strip_mesh(n_length)
        self.model = shell_model(self.mesh, wall)
        self.assembly = assemble(self.model)
        free = np.ones((self.mesh.n_nodes, 6), dtype=bool)
        free[self.mesh.nodes_of("root")] = False
        self.free = np.flatnonzero(free)

    def tip_force(self, force: ArrayLike) -> Array:
        """Load (N, 6) of a dead force (3,), distributed over the tip nodes."""
        load = np.zeros((self.mesh.n_nodes, 6))
        load[self.mesh.nodes_of("tip"), :3] = np.outer([0.25, 0.5, 0.25], np.asarray(force))
        return load

    def tip_couple(self, torque: float) -> Array:
        """Load (N, 6) of a torque about x, N m: opposite dead forces along z at the two edges of the tip."""
        load = np.zeros((self.mesh.n_nodes, 6))
        load[self.mesh.nodes_of("tip")[[0, -1]], 2] = -torque / WIDTH, torque / WIDTH
        return load

    def tangent(self, motion: Array) -> csc_array:
        """Tangent stiffness of the freedoms that are not prescribed."""
        return self.assembly.tangent(motion.ravel())[self.free][:, self.free]

    def bent(self, load: Array, steps: int = 3) -> Array:
        """Nodal freedoms (N, 6) in equilibrium, with the root not rotated relative to the frame."""
        return self._resting(load, np.zeros((self.mesh.n_nodes, 6)), steps)

    def seen_from(self, turn: ArrayLike, load: Array, motion: Array) -> Array:
        """Nodal freedoms (N, 6), in the axes of the root, of the equilibrium computed in a rotated frame.

        turn : rotation vector of the strip and its load relative to the frame
        motion : equilibrium without this rotation; the start of the iteration
        """
        around = Rotation.from_rotvec(turn)
        turned_load = around.apply(load.reshape(-1, 3)).reshape(-1, 6)
        found = self._resting(turned_load, rotated_rigidly(self.mesh, motion, around), 1)
        return rotated_rigidly(self.mesh, found, around.inv())

    def energy(self, turn: Array, motion: Array) -> float:
        """Strain energy, J, of the motion followed by a rigid rotation, with rotation vector `turn`."""
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
