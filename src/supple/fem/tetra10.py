"""Tetrahedron of ten nodes: strain linear over a straight-sided cell, which four points integrate exactly."""

from __future__ import annotations

from supple.fem.quadrature import conical_tetrahedron, four_point_tetrahedron
from supple.fem.solid_element import SolidElement
from supple.mesh.cell_type import CellType

# With curved sides the inertia integrand x^2 det J has degree 4 + 3.
TETRA10_ELEMENT = SolidElement(CellType.TETRA10, four_point_tetrahedron(), conical_tetrahedron(4))
