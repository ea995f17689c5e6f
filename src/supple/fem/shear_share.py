"""Effect of transverse shear on walls that are modelled as rigid in shear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from supple.fem.model import FiniteElementModel, nodal_freedoms
from supple.fem.quadratic_strain import energies
from supple.fem.section import Section
from supple.fem.shell_kinematics import GREEN_LAGRANGE
from supple.fem.shell_section import HomogeneousSection
from supple.fem.shell_triangle import shell_triangle

__all__ = ["shear_share"]

SOLID_WALL = 5 / 6
"""Shear factor of a homogeneous wall."""

# Factor on the shear stiffness for which the shear energy is proportional to the flexibility, on any mesh.
STIFFER = 1e4


def shear_share(model: FiniteElementModel, shapes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ratio (k,) of transverse shear energy to the strain energy of the model, in k linear motions.

    The shear energy is that of homogeneous walls that are modelled as rigid in shear, evaluated from their
    bending with the shear factor 5/6. The ratio is the relative decrease that shear causes in the square of a
    frequency.

    shapes : (n, k) nodal displacements and rotations of the model
    """
    rigid = [
        section
        for section in model.sections
        if isinstance(section.property, HomogeneousSection) and not section.property.shear_factor
    ]
    if not rigid:
        return np.zeros(shapes.shape[1])
    lost = np.zeros(shapes.shape[1])
    for section in rigid:
        wall = section.property
        assert isinstance(wall, HomogeneousSection)
        stiffer = replace(wall, shear_factor=SOLID_WALL * STIFFER)
        energy = [_energy(model, section, each, shapes) for each in (wall, stiffer)]
        lost += STIFFER * (energy[0] - energy[1])
    total = 0.5 * np.einsum("ij,ij->j", shapes, model.stiffness @ shapes)
    return np.divide(lost, total, out=np.zeros_like(lost), where=total > 0)


def _energy(
    model: FiniteElementModel, section: Section, wall: HomogeneousSection, shapes: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Energy (k,), J, of the linear strains of a section with the property `wall`."""
    dofs = nodal_freedoms(section.nodes(model.mesh), 6)
    block = shell_triangle(
        section.corners(model.mesh),
        dofs,
        wall,
        GREEN_LAGRANGE,
        section.directions,
        section.surface_curvature,
    )
    linear = replace(block, N=np.zeros_like(block.N))
    return energies(linear, shapes[dofs]).sum(axis=0)
