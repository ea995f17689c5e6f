"""Flat triangles that are too large for a thin doubly curved wall, whose stiffness is then too high.

The remaining locking grows with `|det K| h^3 / t`, K the surface curvature, h the triangle size, t the wall
thickness: the square of the angle between neighbours, times h / t. Twisted strips and hemispheres are 1 to
10 % too stiff at a value of 2, and 10 to 40 % at 10.
"""

from __future__ import annotations

import warnings

import numpy as np

from supple.arrays import FloatArray
from supple.errors import SuppleWarning
from supple.fem.section import Section
from supple.fem.shell_section import HomogeneousSection, LaminateSection
from supple.fem.shell_triangle import free_bending
from supple.mesh import Mesh
from supple.mesh.facet_curvature import facet_curvature

COARSE = 3.0
"""Value of `|det K| h^3 / t` above which a triangle is coarse."""
SHARE = 0.25
"""Fraction of the area of doubly curved walls above which coarse triangles cause a warning."""
COARSEST = np.radians(45.0)
"""Largest angle, rad, between neighbours on a curved wall; a larger angle is a sharp edge, not curvature."""


def curvature_over_thickness(mesh: Mesh, shells: list[Section]) -> tuple[FloatArray, FloatArray]:
    """`|det K| h^3 / t` (E,) of triangles, 0 without bending stiffness, and their areas (E,).

    h^2 is twice the area, t the thickness of a plain wall of the same ratio of bending to membrane stiffness.
    """
    triangles = np.concatenate([section.nodes(mesh) for section in shells])
    corners = mesh.nodes[triangles]
    twice_area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    curvature = facet_curvature(mesh.nodes, triangles, COARSEST)
    # The eigenvalue of the normal is zero: twice the determinant in the plane is tr^2 - tr(K^2).
    traces = np.trace(curvature, axis1=1, axis2=2), np.einsum("eij,eji->e", curvature, curvature)
    thickness = np.concatenate([np.full(len(section.cells), _thickness(section)) for section in shells])
    return 0.5 * np.abs(traces[0] ** 2 - traces[1]) * twice_area**1.5 / thickness, 0.5 * twice_area


def _thickness(section: Section) -> float:
    """sqrt(12 bending / membrane stiffness), the thickness of a plain wall; infinite if one is zero."""
    wall = section.property
    assert isinstance(wall, HomogeneousSection | LaminateSection)
    stretching = np.trace(wall.membrane)
    bending = np.trace(free_bending(wall)) if stretching > 0 else 0.0
    return float(np.sqrt(12 * bending / stretching)) if bending > 0 else np.inf


def warn_of_coarse_curvature(mesh: Mesh, shells: list[Section]) -> None:
    """Issue a SuppleWarning if coarse triangles exceed the fraction `SHARE` of the doubly curved area."""
    number, area = curvature_over_thickness(mesh, shells)
    coarse = number > COARSE
    if area[coarse].sum() <= SHARE * area[number > 0].sum():
        return
    warnings.warn(
        f"{coarse.sum()} of {(number > 0).sum()} triangles of curved walls are large for their thickness: "
        f"(angle between neighbours)^2 x size / thickness reaches {number.max():.2g}. Above {COARSE:g} a "
        "doubly curved wall is too stiff, at 10 by tens of per cent; refine the mesh there",
        SuppleWarning,
        stacklevel=5,
    )
