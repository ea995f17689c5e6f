"""Stress of the cells of one section: from strains to tensors at points, and from points to nodes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from supple.arrays import FloatArray
from supple.fem.beam2 import BeamLine
from supple.fem.beam_section import BeamSection, LineSection, RodSection
from supple.fem.beam_stress import (
    FIRST,
    SECOND,
    end_forces,
    has_points,
    line_to_global,
    rod_line,
    stress_by_forces,
)
from supple.fem.kinematics import VOIGT
from supple.fem.model import SOLID_ELEMENTS, FiniteElementModel, line_of
from supple.fem.quadratic_strain import QuadraticStrain, strain, strains
from supple.fem.section import Section
from supple.fem.shell_section import HomogeneousSection, LaminateSection
from supple.fem.shell_triangle import element_axes, layer_strain
from supple.fem.solid_element import extrapolation, solid_element, turned_elasticity

LAYERS = (-1.0, 0.0, 1.0)
"""Layers of a shell, bottom, middle and top: z over half the thickness, along the element normal."""


@dataclass(frozen=True, eq=False)
class SectionStress:
    """Stress, or strain, of the cells of one section.

    nodes : (E, k)
    arrays : strain at g points
    of_strain : (E, l', 6, s)    tensors at l' places of a point from the strain of the point: one place in
        solids, the heights in shells, the recovery points of both ends in beams
    to_nodes : (k, l, g l')    from these tensors to l layers at each node of the cell
    first_layer : (E, k)    number, among the layers of the node, of the first of these l
    share : (E, k)    weight of the cell in the nodal average
    turned : (E,)    cells of a shell whose bottom is the top of the wall (`turned_over`); their layers at
        the nodes are exchanged
    """

    nodes: NDArray[np.int64]
    arrays: QuadraticStrain
    of_strain: FloatArray
    to_nodes: FloatArray
    first_layer: NDArray[np.int64]
    share: FloatArray
    turned: NDArray[np.bool_]

    @property
    def is_line(self) -> bool:
        """Whether its cells are beams or rods."""
        return self.nodes.shape[1] == 2

    def at_points(self, displacement: FloatArray) -> FloatArray:
        """Stress (E, g l', 6)."""
        n_cells, _, _, s = self.of_strain.shape
        of_strain = self.of_strain.reshape(n_cells, -1, s)
        stress = strain(self.arrays, displacement[self.arrays.dofs]) @ of_strain.swapaxes(1, 2)
        return stress.reshape(n_cells, -1, 6)

    def at_points_over(self, displacements: FloatArray) -> FloatArray:
        """Stress (E, g l', 6, t) of t displacements (n, t)."""
        n_cells, _, _, s = self.of_strain.shape
        of_strain = self.of_strain.reshape(n_cells, 1, -1, s)
        stress = of_strain @ strains(self.arrays, displacements[self.arrays.dofs])
        return stress.reshape(n_cells, -1, 6, displacements.shape[1])

    def of(self, cells: NDArray[np.int64]) -> SectionStress:
        """The stress of some of the cells, by their numbers in the section."""
        names = ("nodes", "of_strain", "first_layer", "share", "turned")
        own = {name: getattr(self, name)[cells] for name in names}
        return replace(self, arrays=self.arrays.of(cells), **own)

    def in_layers(self, n_layers: int) -> SectionStress:
        """The stress in n_layers layers: a single layer is repeated; n_layers layers stay unchanged."""
        k, _, points = self.to_nodes.shape
        return replace(self, to_nodes=np.broadcast_to(self.to_nodes, (k, n_layers, points)))

    def linearized(self) -> SectionStress:
        """The stress without the quadratic strain."""
        return replace(self, arrays=replace(self.arrays, N=np.zeros_like(self.arrays.N)))

    def shares(self, n_nodes: int, n_layers: int) -> csc_array:
        """Weights of the points in the average in each layer at each node: (N l, E g l')."""
        k, own_layers, n_points = self.to_nodes.shape
        n_cells = len(self.nodes)
        layers, points = np.arange(own_layers)[:, None], np.arange(n_points)
        shape = (n_cells, k, own_layers, n_points)
        first = (self.nodes * n_layers + self.first_layer)[..., None, None]
        rows = np.broadcast_to(first + layers, shape)
        columns = np.broadcast_to(np.arange(n_cells)[:, None, None, None] * n_points + points, shape)
        to_nodes = self.to_nodes
        if self.turned.any():
            to_nodes = np.where(self.turned[:, None, None, None], to_nodes[:, ::-1], to_nodes)
        values = to_nodes * self.share[..., None, None]
        used = values != 0.0
        return csc_array(
            (values[used], (rows[used], columns[used])), shape=(n_nodes * n_layers, n_cells * n_points)
        )


def section_stress(model: FiniteElementModel, section: Section, block: QuadraticStrain) -> SectionStress:
    """The stress of one section of a model that `states_stress`; each cell has weight 1 at its nodes."""
    nodes, corners = section.nodes(model.mesh), section.corners(model.mesh)
    if section.cell_type in SOLID_ELEMENTS:
        element = solid_element(section.cell_type, reduced=section.reduced, incompatible=section.incompatible)
        to_nodes = extrapolation(element)[:, None]
        of_strain = block.D if block.D.ndim == 3 else block.D[None]
        return _made(nodes, block, np.broadcast_to(of_strain[:, None], (len(nodes), 1, 6, 6)), to_nodes)
    given = section.property
    if isinstance(given, BeamSection | RodSection):
        return _line_stress(model, section, block, given)
    assert isinstance(given, HomogeneousSection)
    to_nodes = np.broadcast_to(np.eye(len(LAYERS)), (3, len(LAYERS), len(LAYERS)))
    axes = element_axes(corners, given, section.directions)
    heights = 0.5 * given.thickness * np.array(LAYERS)
    layers = layer_strain(corners, axes, given, heights, section.surface_curvature)
    to_global = _plane_to_global(axes) @ given.material.plane_stress
    return _made(nodes, block, to_global[:, None] @ layers, to_nodes)


def section_forces(model: FiniteElementModel, section: Section, block: QuadraticStrain) -> SectionStress:
    """Section forces N V_y V_z M_x M_y M_z at the ends of beams or rods, in place of stress; one layer."""
    nodes, given = section.nodes(model.mesh), section.property
    assert isinstance(given, LineSection | RodSection)
    of_strain = end_forces(block, _line(model, section).length, given)
    return _made(nodes, block, of_strain, np.eye(2)[:, None])


def states_stress(section: Section) -> bool:
    """Whether stress recovery includes a section.

    False for laminates, whose A-B-D matrix does not define the stress of each ply, and for beams by matrices
    or without recovery points.
    """
    if isinstance(section.property, LaminateSection):
        return False
    return not isinstance(section.property, LineSection) or has_points(section.property)


def as_strain(model: FiniteElementModel, section: Section, stress: SectionStress) -> SectionStress:
    """The strain for a given stress, by the compliance of the material."""
    given = section.property
    if isinstance(given, HomogeneousSection | BeamSection | RodSection):
        elasticity = given.material.elasticity
        if given.material.stated_shear_modulus is not None:  # then it depends on the axes of the element
            corners, directions = section.corners(model.mesh), section.directions
            is_shell = isinstance(given, HomogeneousSection)
            axes = element_axes(corners, given, directions) if is_shell else _line(model, section).axes
            elasticity = turned_elasticity(elasticity, axes.swapaxes(1, 2))[:, None]
        return replace(stress, of_strain=np.linalg.inv(elasticity) @ stress.of_strain)
    return replace(stress, of_strain=np.broadcast_to(np.eye(6), stress.of_strain.shape))


def _made(
    nodes: NDArray[np.int64], block: QuadraticStrain, of_strain: FloatArray, to_nodes: FloatArray
) -> SectionStress:
    return SectionStress(
        nodes,
        block,
        of_strain,
        to_nodes,
        first_layer=np.zeros(nodes.shape, dtype=np.int64),
        share=np.ones(nodes.shape),
        turned=np.zeros(len(nodes), dtype=bool),
    )


def _line(model: FiniteElementModel, section: Section) -> BeamLine:
    corners = section.corners(model.mesh)
    return rod_line(corners) if isinstance(section.property, RodSection) else line_of(model.mesh, section)


def _line_stress(
    model: FiniteElementModel, section: Section, block: QuadraticStrain, given: BeamSection | RodSection
) -> SectionStress:
    """Stress at the points of both ends of beams; the layers of a node are those of its ends."""
    line = _line(model, section)
    to_global = line_to_global(line.axes)[:, None]
    forces = end_forces(block, line.length, given)
    ends = [stress_by_forces(given, end) for end in (FIRST, SECOND)]
    of_strain = [to_global @ by_force @ forces[:, [end]] for end, by_force in enumerate(ends)]
    first, second = (len(by_force) for by_force in ends)
    to_nodes = np.zeros((2, max(first, second), first + second))
    to_nodes[0, :first, :first], to_nodes[1, :second, first:] = np.eye(first), np.eye(second)
    return _made(section.nodes(model.mesh), block, np.concatenate(of_strain, axis=1), to_nodes)


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
