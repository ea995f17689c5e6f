"""Sections: the assignment of materials, shell sections and beam sections to cells of a mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_instance
from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.fem.beam_section import LineSection, RodSection
from supple.fem.material import Anisotropic, Isotropic
from supple.fem.shell_section import ShellSection
from supple.mesh import CellType, Mesh

__all__ = ["Section"]

Property = ShellSection | LineSection | RodSection | Isotropic | Anisotropic
PER_CELL = ("directions", "offsets", "released", "mass_share", "surface_curvature")
"""Fields of a `Section` with one entry per cell."""


@dataclass(frozen=True, eq=False)
class Section:
    """Cells of one type with one property.

    Parameters
    ----------
    cells : int array (E,)                      numbers of the cells within their type
    property : ShellSection (shells), BeamSection, CoupledBeamSection or RodSection (lines), Isotropic or
               Anisotropic (solids)
    directions : float array or None
            beams (E, 3): a vector in the x-y plane of the section; shells (E, 3): a vector whose projection
            on the shell is the x axis of the section; either replaces the direction given in `property`.
            Solids (E, 3, 3): axes of the material, as columns
    offsets : float array (E, 2, 3) or None     rigid arms from the nodes to the beam ends, m
    released : bool array (E, 12) or None       True for freedoms of the beam ends, in beam axes, that carry
                                                no force or moment
    reduced : bool                              for HEXA20: reduced integration, by eight points with weight
        3/4 and fourteen points with weight 1/4
    incompatible : bool                         for HEXA8: incompatible modes, which remove locking in bending
    mass_share : float array (E,) or None       for shells: fraction of a cell's area that has mass; None: 1
    surface_curvature : float array (E, 3, 3) or None
            for shells: curvature, 1/m, of the surface that a flat triangle approximates; by default it is
            computed from neighbouring triangles

    Raises
    ------
    ModelError   an array of another shape, or not finite; offsets or released for cells other than beams;
                 mass_share for cells other than shells
    """

    cell_type: CellType
    cells: IntArray
    property: Property
    directions: FloatArray | None = None
    offsets: FloatArray | None = None
    released: NDArray[np.bool_] | None = None
    reduced: bool = False
    incompatible: bool = True
    mass_share: FloatArray | None = None
    surface_curvature: FloatArray | None = None

    def __post_init__(self) -> None:
        axes = (3, 3) if self.cell_type.dimension == 3 else (3,)
        for name, shape in zip(PER_CELL, (axes, (2, 3), (12,), (), (3, 3)), strict=True):
            given = getattr(self, name)
            if given is None:
                continue
            array = np.array(given, dtype=bool if name == "released" else np.float64)
            wanted = (len(self.cells), *shape)
            if array.shape != wanted:
                raise ModelError(
                    f"{name} of {self.cell_type.name} cells have shape {array.shape}; expected {wanted}"
                )
            if not np.isfinite(array).all():
                raise ModelError(f"{name} of {self.cell_type.name} cells are not all finite")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.mass_share is not None and self.cell_type.dimension != 2:
            raise ModelError(f"mass_share is for shells only; leave it out for {self.cell_type.name} cells")
        if not isinstance(self.property, LineSection):
            for name in ("offsets", "released"):
                if getattr(self, name) is not None:
                    raise ModelError(f"{name} are for beams only, not for {type(self.property).__name__}")

    @property
    def has_incompatible_modes(self) -> bool:
        """Whether the cells are HEXA8 with incompatible modes."""
        return self.incompatible and self.cell_type is CellType.HEXA8

    def turns_nodes(self) -> bool:
        """Whether the cells have stiffness in the nodal rotations."""
        if isinstance(self.property, RodSection):
            return self.property.J > 0
        return self.cell_type.dimension < 3

    def of(self, which: slice | IntArray, cells: IntArray | None = None) -> Section:
        """The section for some of its cells only.

        which : positions of these cells in `cells`
        cells : numbers of these cells in another mesh; None: the same mesh
        """
        own: dict[str, Any] = {
            name: None if (given := getattr(self, name)) is None else given[which] for name in PER_CELL
        }
        return replace(self, cells=self.cells[which] if cells is None else cells, **own)

    def nodes(self, mesh: Mesh) -> IntArray:
        """Node numbers (E, k) of the cells."""
        return mesh.cells[self.cell_type][self.cells]

    def corners(self, mesh: Mesh) -> NDArray[np.float64]:
        """Node positions (E, k, 3) of the cells, m."""
        return mesh.nodes[self.nodes(mesh)]


def sections(mesh: Mesh, given: Property | Mapping[str, Property]) -> tuple[Section, ...]:
    """Sections of a mesh, from one property for all its cells, or one property for each cell set.

    Raises ModelError for a cell without a property, or with two; MeshError for a cell set that the mesh does
    not have.
    """
    check_instance("the mesh of a model", mesh, Mesh, "a Mesh, such as read_mesh(path) returns")
    if not isinstance(given, Mapping):
        return tuple(Section(kind, np.arange(len(cells)), given) for kind, cells in mesh.cells.items())
    found = tuple(
        Section(kind, cells, property)
        for name, property in given.items()
        for kind, cells in mesh.cells_of(name).items()
    )
    for kind, cells in mesh.cells.items():
        count, ids = np.zeros(len(cells), dtype=int), mesh.cell_ids[kind]
        for section in found:
            if section.cell_type is kind:
                count[section.cells] += 1
        if (count == 0).any():
            raise ModelError(
                f"{(count == 0).sum()} of {len(cells)} {kind.name} cells, first {ids[np.argmin(count)]}, "
                f"are in none of the cell sets {sorted(given)}; give every cell a property"
            )
        if (count > 1).any():
            raise ModelError(
                f"{(count > 1).sum()} {kind.name} cells, first {ids[np.argmax(count > 1)]}, are in more than "
                f"one of the cell sets {sorted(given)}; give every cell one property"
            )
    return found
