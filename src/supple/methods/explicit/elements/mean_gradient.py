"""Shape gradients at the strain points of explicit solid elements, from the quadratic-strain arrays.

Tetrahedra use the points of these arrays. The hexahedron has one point, with the gradient averaged over its
volume: its volume change is then exact (Flanagan and Belytschko 1981). Hourglass control resists the
remaining modes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.fem import FiniteElementModel, QuadraticStrain
from supple.fem.section import Section
from supple.mesh import CellType
from supple.methods.explicit.elements.hourglass import hourglass_vectors

__all__ = ["SolidPoints", "solid_points"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SolidPoints:
    """Strain points of E elements of k nodes with g points.

    nodes : int (E, k);   gradients : (E, g, 3, k), 1/m;   volumes : (E, g), m^3
    gamma : (E, 4, k)     hourglass vectors; (E, 0, k) for elements without hourglass modes
    """

    nodes: NDArray[np.int64]
    gradients: FloatArray
    volumes: FloatArray
    gamma: FloatArray


def solid_points(model: FiniteElementModel, section: Section, block: QuadraticStrain) -> SolidPoints:
    """The points of one section; ModelError for cells without an explicit element."""
    kind, nodes = section.cell_type, section.nodes(model.mesh)
    if kind not in (CellType.TETRA4, CellType.TETRA10, CellType.HEXA8):
        raise ModelError(
            f"{kind.name} has no explicit element: use TETRA4, TETRA10 or HEXA8, and "
            "explicit_shell for TRIANGLE3"
        )
    gradients, volumes = block.G[:, :, :3, ::3], block.w
    gamma = np.zeros((len(nodes), 0, nodes.shape[1]))
    if kind is CellType.HEXA8:
        total = volumes.sum(axis=1, keepdims=True)
        gradients = (gradients * (volumes / total)[:, :, None, None]).sum(axis=1, keepdims=True)
        volumes = total
        gamma = hourglass_vectors(section.corners(model.mesh), gradients[:, 0])
    return SolidPoints(nodes, gradients, volumes, gamma)
