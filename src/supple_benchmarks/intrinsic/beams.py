"""Condensed lines of beam elements: exact stiffness between stations, mass lumped at the stations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.fem import BeamSection, Isotropic
from supple.methods.intrinsic import CondensedLine
from supple_benchmarks.lines import condensed_beam

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
    return condensed_beam(name, points, section, radius)
