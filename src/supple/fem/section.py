"""Sections: which cells of a mesh are made of which material, with which shell or beam section."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_instance
from supple.errors import ModelError
from supple.fem.beam_section import BeamSection
from supple.fem.material import Isotropic
from supple.fem.shell_section import ShellSection
from supple.mesh import CellType, Mesh

__all__ = ["Section"]

IntArray = NDArray[np.int64]
Property = ShellSection | BeamSection | Isotropic


@dataclass(frozen=True, eq=False)
class Section:
    """Cells of one type with one property.

    Parameters
    ----------
    cell_type : CellType
    cells : int array (E,)                      numbers of the cells within their type
    property : ShellSection (shells), BeamSection (beams) or Isotropic (solids)
    """

    cell_type: CellType
    cells: IntArray
    property: Property

    def nodes(self, mesh: Mesh) -> IntArray:
        """Node numbers (E, k) of the cells."""
        return mesh.cells[self.cell_type][self.cells]

    def corners(self, mesh: Mesh) -> NDArray[np.float64]:
        """Node positions (E, k, 3) of the cells, m."""
        return mesh.nodes[self.nodes(mesh)]


def sections(mesh: Mesh, given: Property | Mapping[str, Property]) -> tuple[Section, ...]:
    """Sections of a mesh from one property for all its cells, or one for each cell set.

    Raises
    ------
    ModelError   cells without a property, or with two
    MeshError    unknown cell set
    """
    check_instance("the mesh of a model", mesh, Mesh, "a Mesh, such as read_mesh(path) gives")
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
