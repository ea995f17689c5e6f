"""Condensed lines of beam elements: exact stiffness between stations, mass lumped at the stations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.fem import BeamSection, Isotropic, lumped_mass, shell_model
from supple.mesh import CellType, Mesh
from supple.methods.intrinsic import CondensedLine, condensed_line

__all__ = ["beam_line"]

Array = NDArray[np.float64]


def beam_line(
    name: str,
    points: Array,
    *,
    axial: float,
    bending: float,
    torsion: float,
    mass: float,
    radius: float,
) -> CondensedLine:
    """A uniform line of beam elements through points (n, 3), without shear deformation.

    axial, bending, torsion : E A, E I (in both planes), G J;   mass : per length
    radius : radius of gyration of the inertia of the stations, about all three axes
    """
    E = 1.0e6
    material = Isotropic(E, 0.0, mass * E / axial)
    chord = points[-1] - points[0]
    across = np.cross(chord, np.eye(3)[np.argmin(np.abs(chord))])
    section = BeamSection(
        material, axial / E, bending / E, bending / E, 2 * torsion / E, orientation=tuple(across)
    )
    cells = np.column_stack([np.arange(len(points) - 1), np.arange(1, len(points))])
    model = shell_model(Mesh(points, {CellType.LINE2: cells}), section)
    masses = lumped_mass(model).reshape(-1, 6)[:, :1]
    diagonal = np.hstack([np.tile(masses, 3), np.tile(masses * radius**2, 3)])
    return condensed_line(name, points, model.stiffness, sparse.diags_array(diagonal.ravel()))
