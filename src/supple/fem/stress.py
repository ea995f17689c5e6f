"""Stress recovery: second Piola-Kirchhoff stress at points of the cells and at nodes; von Mises stress.

All stresses are in global axes, components xx yy zz yz xz xy; for small strains they are the true stresses
in axes that turn with the material.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.fem.model import SOLID_ELEMENTS, FiniteElementModel
from supple.fem.quadratic_strain import QuadraticStrain, strain
from supple.fem.section import Section
from supple.fem.shell_triangle import element_axes, layer_strain
from supple.fem.shell_wall import HomogeneousWall
from supple.fem.solid_element import extrapolation

FloatArray = NDArray[np.float64]

LAYERS = (-1.0, 0.0, 1.0)
"""Layers of a shell, bottom, middle and top: z over half the thickness, along the element normal."""

VOIGT = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@dataclass(frozen=True, eq=False)
class SectionStress:
    """Stress of the cells of one section.

    Parameters
    ----------
    nodes : int array (E, k)
    arrays : QuadraticStrain                    strain at the g points, and D
    to_global : float array (E, 6, s)           global components from those of the element
    to_nodes : float array (k, l, g)            from the points to l layers at each node of the cell
    """

    nodes: NDArray[np.int64]
    arrays: QuadraticStrain
    to_global: FloatArray
    to_nodes: FloatArray

    def at_points(self, displacement: FloatArray) -> FloatArray:
        """Stress (E, g, 6)."""
        stress = strain(self.arrays, displacement[self.arrays.dofs]) @ self.arrays.D
        return stress @ self.to_global.swapaxes(1, 2)


@dataclass(frozen=True, eq=False)
class StressRecovery:
    """Stress of a model from its nodal displacements; made once, used for every frame."""

    n_nodes: int
    sections: tuple[SectionStress, ...]

    def at_points(self, displacement: FloatArray) -> tuple[FloatArray, ...]:
        """Stress (E, g, 6) of each section, Pa.

        Solids: at the integration points. Shells: at the centroid, g = bottom, middle, top.
        """
        return tuple(section.at_points(displacement) for section in self.sections)

    def at_nodes(self, displacement: FloatArray) -> FloatArray:
        """Stress (N, l, 6) at nodes, Pa: linear from the points of each cell, averaged over its cells.

        Solids have one layer, shells three (bottom, middle, top). Where walls meet at an angle or in
        different thickness the average mixes them; look at the points there.
        """
        n_layers = self.sections[0].to_nodes.shape[1]
        total = np.zeros((self.n_nodes, n_layers, 6))
        count = np.zeros(self.n_nodes)
        for section in self.sections:
            at_corners = np.einsum("klg,egc->eklc", section.to_nodes, section.at_points(displacement))
            np.add.at(total, section.nodes, at_corners)
            np.add.at(count, section.nodes, 1)
        return total / count[:, None, None]


def stress_recovery(model: FiniteElementModel) -> StressRecovery:
    """Prepare the stress recovery of a model.

    Raises
    ------
    ModelError   a laminate wall: its A-B-D matrix does not say which stress acts in which ply
    """
    pairs = zip(model.sections, model.blocks, strict=True)
    return StressRecovery(model.mesh.n_nodes, tuple(_section(model, *pair) for pair in pairs))


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises stress (...) of stresses (..., 6): sqrt(3/2 s:s) of the deviator s."""
    deviator = stress.copy()
    deviator[..., :3] -= stress[..., :3].mean(axis=-1, keepdims=True)
    return np.sqrt(1.5 * ((deviator[..., :3] ** 2).sum(axis=-1) + 2 * (deviator[..., 3:] ** 2).sum(axis=-1)))


def _section(model: FiniteElementModel, section: Section, block: QuadraticStrain) -> SectionStress:
    nodes, corners = section.nodes(model.mesh), section.corners(model.mesh)
    if section.cell_type in SOLID_ELEMENTS:
        to_nodes = extrapolation(SOLID_ELEMENTS[section.cell_type])[:, None]
        return SectionStress(nodes, block, np.broadcast_to(np.eye(6), (len(nodes), 6, 6)), to_nodes)
    wall = section.property
    if not isinstance(wall, HomogeneousWall):
        raise ModelError(
            "stress needs a HomogeneousWall; an A-B-D matrix does not say the stress of each ply"
        )
    to_nodes = np.broadcast_to(np.eye(len(LAYERS)), (3, len(LAYERS), len(LAYERS)))
    arrays = layer_strain(corners, block, wall, LAYERS)
    return SectionStress(nodes, arrays, _plane_to_global(element_axes(corners, wall)), to_nodes)


def _plane_to_global(axes: FloatArray) -> FloatArray:
    """Global components (E, 6, 3) of plane stress xx yy xy in the axes (E, 3, 3) of each element."""
    x, y = axes[:, 0], axes[:, 1]
    columns = [(x, x, 1.0), (y, y, 1.0), (x, y, 2.0)]
    return np.stack(
        [
            np.stack([0.5 * f * (a[:, i] * b[:, j] + a[:, j] * b[:, i]) for a, b, f in columns], axis=1)
            for i, j in VOIGT
        ],
        axis=1,
    )
