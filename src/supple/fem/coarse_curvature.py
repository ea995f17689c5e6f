"""Flat triangles that are too large for the curvature of a thin wall: where it is still too stiff.

What is left of locking grows with `K^2 h^3 / t`: the angle Kh between neighbours squared, times size over
thickness. Twisted strips and hemispheres are 1 to 10 % too stiff where it is 2, and 10 to 40 % at 10.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from supple.errors import SuppleWarning
from supple.fem.section import Section
from supple.fem.shell_section import HomogeneousSection, LaminateSection
from supple.fem.shell_triangle import free_bending
from supple.mesh import Mesh

__all__ = ["curvature_over_thickness", "warn_of_coarse_curvature"]

FloatArray = NDArray[np.float64]

COARSE = 3.0
SHARE = 0.25
"""Of the area of curved walls, that may be coarser without a warning."""


def curvature_over_thickness(mesh: Mesh, section: Section) -> tuple[FloatArray, FloatArray]:
    """`K^2 h^3 / t` of the triangles of a section, 0 where nothing bends or curves, and their areas, (E,).

    K is the largest curvature, h^2 twice the area, t the thickness of a plain wall that bends as stiffly.
    """
    corners, wall = section.corners(mesh), section.property
    twice_area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    assert isinstance(wall, HomogeneousSection | LaminateSection)
    stretching = np.trace(wall.membrane)
    bending = np.trace(free_bending(wall)) if stretching > 0 else 0.0
    if section.surface_curvature is None or not bending > 0:
        return np.zeros(len(corners)), 0.5 * twice_area
    K = np.abs(np.linalg.eigvalsh(section.surface_curvature)).max(axis=1)
    return K**2 * twice_area**1.5 / np.sqrt(12 * bending / stretching), 0.5 * twice_area


def warn_of_coarse_curvature(mesh: Mesh, shells: list[Section]) -> None:
    """SuppleWarning where a good part of the curved walls is coarse for its curvature."""
    if not shells:
        return
    found = [curvature_over_thickness(mesh, section) for section in shells]
    number, area = (np.concatenate(each) for each in zip(*found, strict=True))
    coarse = number > COARSE
    if area[coarse].sum() <= SHARE * area[number > 0].sum():
        return
    warnings.warn(
        f"{coarse.sum()} of {(number > 0).sum()} triangles of curved walls are large for their thickness: "
        f"(angle between neighbours)^2 x size / thickness reaches {number.max():.2g}, and above {COARSE:g} a "
        "wall is too stiff, by tens of per cent at 10; refine the mesh along its curvature",
        SuppleWarning,
        stacklevel=5,
    )
