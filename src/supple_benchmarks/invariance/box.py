"""A slender thin-walled box: a shell model, and a beam model of the same section."""

from __future__ import annotations

import numpy as np

from supple.fem import BeamSection, FiniteElementModel, HomogeneousSection, Isotropic, shell_model
from supple.mesh import box_beam
from supple_benchmarks.lines import line_mesh, points_along_x

__all__ = ["BOX_LENGTH", "SECTION", "beam_stiffness", "box_of_beams", "box_of_walls", "weak_bending"]

BOX_LENGTH, WIDTH, HEIGHT, WALL = 20.0, 1.0, 0.5, 0.04
MATERIAL = Isotropic(5.5e9, 0.3, 2700.0)


def _thin(width: float, height: float) -> tuple[float, float]:
    """Area, and second moment of area about the axis along the width, of a thin-walled rectangular tube."""
    return 2 * WALL * (width + height), 2 * WALL * (width * height**2 / 4 + height**3 / 12)


AREA, WEAK = _thin(WIDTH, HEIGHT)
_, STRONG = _thin(HEIGHT, WIDTH)
TWIST = 2 * WALL * (WIDTH * HEIGHT) ** 2 / (WIDTH + HEIGHT)
"""Torsion constant by Bredt's formula, 4 A^2 t / circumference, with the enclosed area A, m4."""
SHEAR_FACTOR = 0.5
SECTION = BeamSection(MATERIAL, AREA, STRONG, WEAK, TWIST, SHEAR_FACTOR, SHEAR_FACTOR, orientation=(0, 1, 0))


def weak_bending() -> float:
    """Bending stiffness E I about y, N m2."""
    return MATERIAL.youngs_modulus * WEAK


def beam_stiffness() -> np.ndarray:
    """Stiffness (6,) of the reference beam: E A, G A k along y and z, G J, E I about y (weak), z (strong)."""
    E, G = MATERIAL.youngs_modulus, MATERIAL.shear_modulus
    shear = G * AREA * SHEAR_FACTOR
    return np.array([E * AREA, shear, shear, G * TWIST, E * WEAK, E * STRONG])


def box_of_beams(n_length: int) -> FiniteElementModel:
    """The box as beam elements along x; node sets root and tip are the end nodes."""
    return shell_model(line_mesh(points_along_x(BOX_LENGTH, n_length)), SECTION)


def box_of_walls(n_length: int = 16) -> FiniteElementModel:
    """The box as shells; node sets root and tip are the rings of nodes at its ends."""
    mesh = box_beam(length=BOX_LENGTH, width=WIDTH, height=HEIGHT, n_length=n_length, n_width=2, n_height=2)
    return shell_model(mesh, HomogeneousSection(MATERIAL, WALL))
