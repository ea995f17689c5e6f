"""Stress recovery: second Piola-Kirchhoff stress at points of the cells and at nodes; von Mises stress.

All stresses are in global axes, components xx yy zz yz xz xy; for small strains they are the true stresses
in axes that turn with the material. Strains likewise, with engineering shears.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

from supple.errors import ModelError
from supple.fem.attached import RigidPiece
from supple.fem.kinematics import VOIGT
from supple.fem.material import Anisotropic, Isotropic
from supple.fem.model import SOLID_ELEMENTS, FiniteElementModel
from supple.fem.quadratic_strain import QuadraticStrain, strain, strains
from supple.fem.section import Section
from supple.fem.shell_section import HomogeneousSection
from supple.fem.shell_triangle import element_axes, layer_strain
from supple.fem.solid_element import extrapolation, solid_element

__all__ = [
    "StressRecovery",
    "has_stress",
    "strain_recovery",
    "stress_recovery",
    "von_mises",
    "von_mises_strain",
]

FloatArray = NDArray[np.float64]

LAYERS = (-1.0, 0.0, 1.0)
"""Layers of a shell, bottom, middle and top: z over half the thickness, along the element normal."""


@dataclass(frozen=True, eq=False)
class SectionStress:
    """Stress, or strain, of the cells of one section.

    Parameters
    ----------
    nodes : int array (E, k)
    arrays : QuadraticStrain                    strain at g points
    of_strain : float array (E, l', 6, s)       tensors at l' heights of a point (1 in solids) from its strain
    to_nodes : float array (k, l, g l')         from these tensors to l layers at each node of the cell
    """

    nodes: NDArray[np.int64]
    arrays: QuadraticStrain
    of_strain: FloatArray
    to_nodes: FloatArray

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
        """The same for some of the cells."""
        return replace(
            self, nodes=self.nodes[cells], arrays=self.arrays.of(cells), of_strain=self.of_strain[cells]
        )

    def in_layers(self, n_layers: int) -> SectionStress:
        """The same with its one layer, where it has one, repeated."""
        k, _, points = self.to_nodes.shape
        return replace(self, to_nodes=np.broadcast_to(self.to_nodes, (k, n_layers, points)))

    def linearized(self) -> SectionStress:
        """The same without the quadratic strain."""
        return replace(self, arrays=replace(self.arrays, N=np.zeros_like(self.arrays.N)))

    def shares(self, n_nodes: int, cells_at_node: NDArray[np.int64]) -> csc_array:
        """What each point gives to the mean over the cells at each node: (N l, E g)."""
        k, n_layers, n_points = self.to_nodes.shape
        n_cells = len(self.nodes)
        layers, points = np.arange(n_layers)[:, None], np.arange(n_points)
        shape = (n_cells, k, n_layers, n_points)
        rows = np.broadcast_to(self.nodes[..., None, None] * n_layers + layers, shape)
        columns = np.broadcast_to(np.arange(n_cells)[:, None, None, None] * n_points + points, shape)
        values = self.to_nodes / cells_at_node[self.nodes][..., None, None]
        used = values != 0.0
        return csc_array(
            (values[used], (rows[used], columns[used])), shape=(n_nodes * n_layers, n_cells * n_points)
        )


@dataclass(frozen=True, eq=False)
class StressRecovery:
    """Stress, or strain, of a model from its nodal displacements; made once, used for every frame."""

    n_nodes: int
    sections: tuple[SectionStress, ...]
    pieces: tuple[RigidPiece, ...] = ()
    """Nodes that move as one, to second order in their rotation: elements beside them see it"""

    def linearized(self) -> StressRecovery:
        """The stress of the linear strain alone, which belongs to a body's linear stiffness."""
        return replace(self, sections=tuple(section.linearized() for section in self.sections))

    @property
    def n_layers(self) -> int:
        """Layers l at a node: 1 (solids) or 3 (shells, and solids beside them)."""
        return self.sections[0].to_nodes.shape[1]

    @cached_property
    def averaging(self) -> tuple[csc_array, ...]:
        """For each section, the matrix (N l, E g) from its points to the layers at the nodes."""
        cells_at_node = np.zeros(self.n_nodes, dtype=np.int64)
        for section in self.sections:
            np.add.at(cells_at_node, section.nodes, 1)
        return tuple(section.shares(self.n_nodes, cells_at_node) for section in self.sections)

    def around(self, nodes: NDArray[np.int64]) -> StressRecovery:
        """The recovery with the cells at some nodes alone, which is right at these nodes.

        Raises ModelError where one of the nodes belongs to no cell.
        """
        cells = [np.flatnonzero(np.isin(section.nodes, nodes).any(axis=1)) for section in self.sections]
        kept = tuple(section.of(own) for section, own in zip(self.sections, cells, strict=True) if len(own))
        known = np.concatenate([section.nodes.ravel() for section in kept]) if kept else np.empty(0)
        alone = np.setdiff1d(nodes, known)
        if alone.size:
            raise ModelError(
                f"node number {alone[0]} (of {alone.size}) belongs to no element: there is no stress; choose "
                "nodes of elements"
            )
        return replace(self, sections=kept)

    def at_points(self, displacement: FloatArray) -> tuple[FloatArray, ...]:
        """Stress (E, g, 6) of each section, Pa.

        Solids: at the integration points. Shells: at the centroid, g = bottom, middle, top.
        """
        return tuple(section.at_points(displacement) for section in self.sections)

    def at_nodes(self, displacement: FloatArray) -> FloatArray:
        """Stress (N, l, 6) at nodes, Pa: linear from the points of each cell, averaged over its cells.

        Solids have one layer, shells three (bottom, middle, top). Where shells meet at an angle or in
        different thickness the average mixes them; look at the points there.
        """
        total = np.zeros((self.n_nodes * self.n_layers, 6))
        for section, averaging in zip(self.sections, self.averaging, strict=True):
            total += averaging @ section.at_points(displacement).reshape(-1, 6)
        return total.reshape(self.n_nodes, self.n_layers, 6)

    def averaging_at(self, nodes: NDArray[np.int64]) -> tuple[csr_array, ...]:
        """The rows (k l, E g) of the matrices of `averaging` at k nodes."""
        rows = (nodes[:, None] * self.n_layers + np.arange(self.n_layers)).ravel()
        return tuple(averaging.tocsr()[rows] for averaging in self.averaging)

    def over(self, displacements: FloatArray, averaging: tuple[csr_array, ...]) -> FloatArray:
        """`at_nodes` of t displacements (n, t) at the k nodes of an averaging: (t, k, l, 6)."""
        t = displacements.shape[1]
        total = np.zeros((averaging[0].indptr.size - 1, 6 * t))
        for section, own in zip(self.sections, averaging, strict=True):
            total += own @ section.at_points_over(displacements).reshape(-1, 6 * t)
        return np.moveaxis(total.reshape(-1, self.n_layers, 6, t), -1, 0)

    @property
    def numbers_per_instant(self) -> int:
        """How many numbers `over` forms for every displacement, about."""
        return sum(
            section.arrays.dofs.size + (section.arrays.G.shape[2] + 12) * section.arrays.w.size
            for section in self.sections
        )


def stress_recovery(model: FiniteElementModel) -> StressRecovery:
    """Prepare the stress recovery of a model.

    Raises
    ------
    ModelError   a laminate: its A-B-D matrix does not say which stress acts in which ply
    """
    pairs = zip(model.sections, model.blocks, strict=True)
    sections = [_section(model, *pair) for pair in pairs]
    n_layers = max(section.to_nodes.shape[1] for section in sections)
    # Solids beside shells have the same stress in all layers.
    pieces = model.attached.rigid if model.strains_vanish_when_turned else ()
    layered = tuple(section.in_layers(n_layers) for section in sections)
    return StressRecovery(model.mesh.n_nodes, layered, pieces)


def has_stress(model: FiniteElementModel) -> bool:
    """Whether every section says where its stress acts: solids and homogeneous shells do."""
    states_stress = Isotropic | Anisotropic | HomogeneousSection
    return all(isinstance(section.property, states_stress) for section in model.sections)


def strain_recovery(model: FiniteElementModel) -> StressRecovery:
    """Prepare the recovery of Green-Lagrange strain, with a shell's strain through its thickness.

    The strain is the material's compliance times the stress, so what is recovered and how it is averaged
    are those of `stress_recovery`; its shears are engineering ones.

    Raises
    ------
    ModelError   as for stress_recovery
    """
    recovery = stress_recovery(model)
    pairs = zip(model.sections, recovery.sections, strict=True)
    return replace(recovery, sections=tuple(_as_strain(*pair) for pair in pairs))


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises stress (...) of stresses (..., 6): sqrt(3/2 s:s) of the deviator s."""
    xx, yy, zz, yz, xz, xy = np.moveaxis(stress, -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(0.5 * normal + 3.0 * (yz**2 + xz**2 + xy**2))


def von_mises_strain(strain: FloatArray) -> FloatArray:
    """Von Mises equivalent strain (...) of strains (..., 6) with engineering shears: sqrt(2/3 e:e).

    e is the deviator. In an isotropic material it is the von Mises stress over 3 G; in uniaxial tension
    2 (1 + nu) / 3 times the stretch.
    """
    half = strain * [1.0, 1.0, 1.0, 0.5, 0.5, 0.5]
    return von_mises(half) / 1.5


def _as_strain(section: Section, stress: SectionStress) -> SectionStress:
    given = section.property
    if not isinstance(given, HomogeneousSection):  # a solid: stress_recovery has refused the others
        return replace(stress, of_strain=np.broadcast_to(np.eye(6), stress.of_strain.shape))
    return replace(stress, of_strain=np.linalg.inv(given.material.elasticity) @ stress.of_strain)


def _section(model: FiniteElementModel, section: Section, block: QuadraticStrain) -> SectionStress:
    nodes, corners = section.nodes(model.mesh), section.corners(model.mesh)
    if section.cell_type in SOLID_ELEMENTS:
        element = solid_element(section.cell_type, reduced=section.reduced, incompatible=section.incompatible)
        to_nodes = extrapolation(element)[:, None]
        of_strain = block.D if block.D.ndim == 3 else block.D[None]
        return SectionStress(
            nodes, block, np.broadcast_to(of_strain[:, None], (len(nodes), 1, 6, 6)), to_nodes
        )
    given = section.property
    if section.cell_type.dimension == 1:
        raise ModelError("no stress recovery for beams: their sections do not say where the stress acts")
    if not isinstance(given, HomogeneousSection):
        raise ModelError(
            "stress needs a HomogeneousSection; an A-B-D matrix does not say the stress of each ply"
        )
    to_nodes = np.broadcast_to(np.eye(len(LAYERS)), (3, len(LAYERS), len(LAYERS)))
    axes = element_axes(corners, given, section.directions)
    heights = 0.5 * given.thickness * np.array(LAYERS)
    layers = layer_strain(corners, axes, given, heights, section.surface_curvature)
    to_global = _plane_to_global(axes) @ given.material.plane_stress
    return SectionStress(nodes, block, to_global[:, None] @ layers, to_nodes)


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
