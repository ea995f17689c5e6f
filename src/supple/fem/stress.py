"""Stress recovery: second Piola-Kirchhoff stress at points of the cells and at nodes; von Mises stress.

All stresses are in global axes, components xx yy zz yz xz xy; for small strains they are the true stresses
in axes that rotate with the material. Strains are in global axes too, with engineering shears.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem.attached import RigidPiece
from supple.fem.beam_section import LineSection, RodSection
from supple.fem.beam_stress import FIRST, SECOND, stress_by_forces
from supple.fem.model import FiniteElementModel
from supple.fem.section_stress import (
    LAYERS,
    SectionStress,
    as_strain,
    section_forces,
    section_stress,
    states_stress,
)
from supple.fem.shell_section import LaminateSection
from supple.mesh import CellType
from supple.mesh.facet_curvature import SMOOTH, turned_over

__all__ = [
    "StressLayers",
    "StressRecovery",
    "beam_end_ranks",
    "beam_force_recovery",
    "beam_forces",
    "cells_without_stress",
    "has_stress",
    "has_stress_on_faces",
    "model_of_cells",
    "node_of_several_walls",
    "strain_recovery",
    "stress_layers",
    "stress_recovery",
    "von_mises",
    "von_mises_strain",
]


@dataclass(frozen=True)
class StressLayers:
    """The layers of a node: those of solids and shells, then the points of each beam end there.

    Ends of beams at a common node keep separate layers, in the order of the cells: their section forces
    differ by the load on the node, and in a frame by their directions.

    walls : 0, 1 (solids) or 3 (shells, and solids beside them)
    points : largest number of recovery points of a beam end
    ends : largest number of beam ends at a node
    """

    walls: int
    points: int
    ends: int

    @property
    def count(self) -> int:
        """Number l of layers of a node."""
        return self.walls + self.points * self.ends

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the layers; an empty name for solids alone."""
        walls = ("bottom", "middle", "top") if self.walls > 1 else ("solid",) * self.walls
        if not self.ends:
            return walls if self.walls > 1 else ("",)
        return (
            *walls,
            *(f"beam {end + 1} point {p + 1}" for end in range(self.ends) for p in range(self.points)),
        )

    def largest(self, values: FloatArray) -> FloatArray:
        """Largest value (or 0) of values (..., l) in walls, then in each beam end: (..., 1 + ends)."""
        ends = values[..., self.walls :].reshape(*values.shape[:-1], self.ends, self.points)
        walls = values[..., : self.walls].max(axis=-1, initial=0.0)
        return np.concatenate([walls[..., None], ends.max(axis=-1, initial=0.0)], axis=-1)

    @property
    def outer(self) -> tuple[int, ...]:
        """Layers where von Mises stress, convex in stress, can be largest; stress is linear through walls."""
        walls = (0, 2) if self.walls > 1 else (0,) * self.walls
        return (*walls, *range(self.walls, self.count))


@dataclass(frozen=True, eq=False)
class StressRecovery:
    """Stress, or strain, of a model from its nodal displacements; prepared once for all output times."""

    node_ids: NDArray[np.int64]
    sections: tuple[SectionStress, ...]
    layers: StressLayers
    pieces: tuple[RigidPiece, ...] = ()
    """Nodes tied rigidly, to second order in their rotation; these ties add strain in adjacent elements"""

    def linearized(self) -> StressRecovery:
        """The stress of the linear strain alone, for a body's linear stiffness."""
        return replace(self, sections=tuple(section.linearized() for section in self.sections))

    @property
    def n_nodes(self) -> int:
        """Number of nodes N of the mesh."""
        return len(self.node_ids)

    @property
    def n_layers(self) -> int:
        """Layers l at a node."""
        return self.layers.count

    @cached_property
    def averaging(self) -> tuple[csc_array, ...]:
        """For each section, the matrix (N l, E g) from its points to the layers at the nodes."""
        return tuple(section.shares(self.n_nodes, self.n_layers) for section in self.sections)

    def layers_at(self, nodes: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether each of k nodes has each layer, (k, l); in a missing layer the stress is zero."""
        there = sum(np.diff(own.indptr) for own in self.averaging_at(nodes))
        return (np.asarray(there) > 0).reshape(len(nodes), self.n_layers)

    def around(self, nodes: NDArray[np.int64]) -> StressRecovery:
        """The recovery restricted to the cells at some nodes, exact at these nodes.

        Raises ModelError where one of the nodes belongs to no cell with stress.
        """
        cells = [np.flatnonzero(np.isin(section.nodes, nodes).any(axis=1)) for section in self.sections]
        kept = tuple(section.of(own) for section, own in zip(self.sections, cells, strict=True) if len(own))
        known = np.concatenate([section.nodes.ravel() for section in kept]) if kept else np.empty(0)
        alone = np.setdiff1d(nodes, known)
        if alone.size:
            raise ModelError(
                f"node {self.node_ids[alone[0]]} (one of {alone.size} such nodes) belongs to no element with "
                "stress: choose nodes of solids, of homogeneous shells, or of beams with recovery points"
            )
        return replace(self, sections=kept)

    def at_points(self, displacement: FloatArray) -> tuple[FloatArray, ...]:
        """Stress (E, g, 6) of each section, Pa.

        Solids: at the integration points. Shells: at the centroid, g = bottom, middle, top. Beams: at the
        points of their first, then of their second end.
        """
        return tuple(section.at_points(displacement) for section in self.sections)

    def at_nodes(self, displacement: FloatArray) -> FloatArray:
        """Stress (N, l, 6) at nodes, Pa: from a linear fit in each cell, averaged over the cells of a node.

        Layers are those of `StressLayers`. Bottom and top of a shell are those of most elements of its wall
        (`turned_over`). Where shells meet at an angle or in different thickness, or where materials meet, the
        average mixes their stresses; use `at_points` there. Ends of beams are not averaged.
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
        """`at_nodes` for t displacements (n, t) at the k nodes of an averaging: (t, k, l, 6)."""
        t = displacements.shape[1]
        total = np.zeros((averaging[0].indptr.size - 1, 6 * t))
        for section, own in zip(self.sections, averaging, strict=True):
            total += own @ section.at_points_over(displacements).reshape(-1, 6 * t)
        return np.moveaxis(total.reshape(-1, self.n_layers, 6, t), -1, 0)

    @property
    def numbers_per_instant(self) -> int:
        """Approximate storage (numbers) of `over` for each displacement."""
        return sum(
            section.arrays.dofs.size + (section.arrays.G.shape[2] + 12) * section.arrays.w.size
            for section in self.sections
        )


def stress_recovery(model: FiniteElementModel) -> StressRecovery:
    """Prepare the stress recovery of a model.

    Laminates, beams given by matrices, and beams without points of stress recovery are left out.

    Raises
    ------
    ModelError   no section has stress: laminates, whose A-B-D matrix does not define the stress of each ply,
                 or beams without recovery points
    """
    made = [
        section_stress(model, section, block)
        for section, block in zip(model.sections, model.blocks, strict=True)
        if states_stress(section)
    ]
    if not made:
        if any(isinstance(section.property, LaminateSection) for section in model.sections):
            raise ModelError(
                "stress needs a HomogeneousSection; an A-B-D matrix does not define the stress of each ply"
            )
        raise ModelError(
            "no stress recovery for beams whose sections have no recovery points: give "
            "BeamSection a geometry, such as rectangular_section(height, width), or the deck's property "
            "points C, D, E, F"
        )
    layers = stress_layers(model)
    # Solids beside shells have the same stress in all layers.
    walls = [each.in_layers(layers.walls) for each in made if not each.is_line]
    walls = _of_one_side(walls, model.mesh.nodes)
    sections = (*_averaged(walls, model.mesh.n_nodes), *_stacked([s for s in made if s.is_line], layers))
    return StressRecovery(model.mesh.node_ids, sections, layers, _pieces(model))


def beam_forces(model: FiniteElementModel, displacement: FloatArray) -> FloatArray:
    """N V_y V_z M_x M_y M_z (E, 2, 6) at the ends of all LINE2 cells, in the order of the mesh; N, N m.

    They are the forces that the part towards the second end exerts on the part before the section. Components
    are along the axes of the section (`BeamSection`), which rotate with it; M_x is about the axis of the
    beam, its shear centre. Two cells that share a node differ there by the load on it.

    displacement : (n,) nodal freedoms, m and rad
    """
    found = np.zeros((len(_lines(model)), 2, 6))
    for section, block in zip(model.sections, model.blocks, strict=True):
        if section.cell_type is CellType.LINE2:
            found[section.cells] = section_forces(model, section, block).at_points(displacement)
    return found


def beam_force_recovery(model: FiniteElementModel, cell: int) -> StressRecovery:
    """Section forces of one LINE2 cell by its number, in place of stresses, at its two nodes alone.

    Raises ModelError where there is no such cell.
    """
    for section, block in zip(model.sections, model.blocks, strict=True):
        own = np.flatnonzero(section.cells == cell)
        if section.cell_type is CellType.LINE2 and own.size:
            forces = section_forces(model, section.of(own), block.of(own))
            return StressRecovery(model.mesh.node_ids, (forces,), StressLayers(1, 0, 0), _pieces(model))
    raise ModelError(f"there is no beam or rod number {cell}; the mesh has {len(_lines(model))} LINE2 cells")


def stress_layers(model: FiniteElementModel) -> StressLayers:
    """The layers of the nodes of a model, without building its elements."""
    stating = [section for section in model.sections if states_stress(section)]
    walls = [
        len(LAYERS) if section.cell_type.dimension == 2 else 1
        for section in stating
        if section.cell_type is not CellType.LINE2
    ]
    lines = [section for section in stating if section.cell_type is CellType.LINE2]
    points = [
        len(stress_by_forces(section.property, end))
        for section in lines
        if isinstance(section.property, LineSection | RodSection)
        for end in (FIRST, SECOND)
    ]
    at_nodes = np.bincount(
        np.concatenate([np.zeros(0, dtype=np.int64), *(s.nodes(model.mesh).ravel() for s in lines)])
    )
    return StressLayers(max(walls, default=0), max(points, default=0), int(at_nodes.max(initial=0)))


def beam_end_ranks(model: FiniteElementModel) -> dict[int, NDArray[np.int64]]:
    """Rank of each beam end (E, 2) among the ends at its node, for each section with stress, by number."""
    numbers = [
        number
        for number, section in enumerate(model.sections)
        if section.cell_type is CellType.LINE2 and states_stress(section)
    ]
    ranks = _ranks([model.sections[number].nodes(model.mesh) for number in numbers])
    return dict(zip(numbers, ranks, strict=True))


def has_stress(model: FiniteElementModel) -> bool:
    """Whether stress is defined for some section."""
    return any(states_stress(section) for section in model.sections)


def has_stress_on_faces(model: FiniteElementModel) -> NDArray[np.bool_]:
    """Whether each node (N,) belongs to a solid or shell that has stress."""
    found = np.zeros(model.mesh.n_nodes, dtype=bool)
    for section in model.sections:
        if section.cell_type is not CellType.LINE2 and states_stress(section):
            found[section.nodes(model.mesh)] = True
    return found


def model_of_cells(model: FiniteElementModel, cell_set: str) -> FiniteElementModel:
    """The model with the stress of the elements in one cell set alone, for sensors where walls meet.

    Its mass and stiffness are still those of all elements.
    Raises MeshError for a cell set that the mesh does not have.
    """
    chosen = model.mesh.cells_of(cell_set)
    own = [np.flatnonzero(np.isin(each.cells, chosen.get(each.cell_type, ()))) for each in model.sections]
    kept = [section.of(some) for section, some in zip(model.sections, own, strict=True) if len(some)]
    return replace(model, sections=tuple(kept))


def node_of_several_walls(model: FiniteElementModel, nodes: NDArray[np.int64]) -> int | None:
    """The first of some nodes at which shells with stress meet at more than 60 degrees; None without one."""
    shells = [
        section
        for section in model.sections
        if section.cell_type is CellType.TRIANGLE3 and states_stress(section)
    ]
    triangles = np.concatenate([np.empty((0, 3), int), *(section.nodes(model.mesh) for section in shells)])
    triangles = triangles[np.isin(triangles, nodes).any(axis=1)]
    corners = model.mesh.nodes[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    for node in nodes:
        own = normals[(triangles == node).any(axis=1)]
        if (abs(own @ own.T) < np.cos(SMOOTH)).any():
            return int(node)
    return None


def cells_without_stress(model: FiniteElementModel) -> int:
    """Number of cells without stress: laminates, beams given by matrices, beams without recovery points."""
    return sum(len(section.cells) for section in model.sections if not states_stress(section))


def strain_recovery(model: FiniteElementModel) -> StressRecovery:
    """Prepare the recovery of Green-Lagrange strain, with a shell's strain through its thickness.

    The strain is the material's compliance times the stress, so recovery and averaging are those of
    `stress_recovery`; shears are engineering shears.

    Raises
    ------
    ModelError   as for stress_recovery
    """
    recovery = stress_recovery(model)
    stating = [section for section in model.sections if states_stress(section)]
    # Shells and solids come before lines.
    stating.sort(key=lambda section: section.cell_type is CellType.LINE2)
    pairs = zip(stating, recovery.sections, strict=True)
    return replace(recovery, sections=tuple(as_strain(model, *pair) for pair in pairs))


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises stress (...) of stresses (..., 6): sqrt(3/2 s:s) of the deviator s."""
    xx, yy, zz, yz, xz, xy = np.moveaxis(stress, -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(0.5 * normal + 3.0 * (yz**2 + xz**2 + xy**2))


def von_mises_strain(strain: FloatArray) -> FloatArray:
    """Von Mises equivalent strain (...) of strains (..., 6) with engineering shears: sqrt(2/3 e:e).

    e is the deviator. In an isotropic material the equivalent strain is the von Mises stress over 3 G; in
    uniaxial tension it is 2 (1 + nu) / 3 times the axial strain.
    """
    half = strain * [1.0, 1.0, 1.0, 0.5, 0.5, 0.5]
    return von_mises(half) / 1.5


def _of_one_side(walls: Sequence[SectionStress], nodes: FloatArray) -> list[SectionStress]:
    """Solids and shells; of shells, the sides of a wall are those of most of its cells."""
    shells = [number for number, section in enumerate(walls) if section.nodes.shape[1] == 3]
    found = list(walls)
    if shells:
        turned = turned_over(nodes, np.concatenate([walls[number].nodes for number in shells]))
        parts = np.split(turned, np.cumsum([len(walls[number].nodes) for number in shells])[:-1])
        for number, own in zip(shells, parts, strict=True):
            found[number] = replace(walls[number], turned=own)
    return found


def _averaged(walls: Sequence[SectionStress], n_nodes: int) -> Iterator[SectionStress]:
    """Solids and shells, with nodal weights for the average over their cells."""
    cells_at_node = np.zeros(n_nodes, dtype=np.int64)
    for section in walls:
        np.add.at(cells_at_node, section.nodes, 1)
    for section in walls:
        yield replace(section, share=1 / cells_at_node[section.nodes])


def _stacked(lines: Sequence[SectionStress], layers: StressLayers) -> Iterator[SectionStress]:
    """Beams and rods, with separate layers for every end at its node, in the order of the cells."""
    for section, rank in zip(lines, _ranks([section.nodes for section in lines]), strict=True):
        yield replace(section, first_layer=layers.walls + layers.points * rank)


def _ranks(lines: Sequence[NDArray[np.int64]]) -> list[NDArray[np.int64]]:
    """Number of earlier ends at the node of each end, (E, 2), for the nodes (E, 2) of each section."""
    if not lines:
        return []
    nodes = np.concatenate([own.ravel() for own in lines])
    order = np.argsort(nodes, kind="stable")
    in_order = nodes[order]
    rank = np.empty_like(nodes)
    rank[order] = np.arange(len(nodes)) - np.searchsorted(in_order, in_order)
    parts = np.split(rank, np.cumsum([own.size for own in lines])[:-1])
    return [part.reshape(own.shape) for part, own in zip(parts, lines, strict=True)]


def _pieces(model: FiniteElementModel) -> tuple[RigidPiece, ...]:
    return model.attached.rigid if model.strains_vanish_in_rotation else ()


def _lines(model: FiniteElementModel) -> NDArray[np.int64]:
    return model.mesh.cells.get(CellType.LINE2, np.empty((0, 2), dtype=np.int64))
