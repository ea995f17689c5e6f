"""Tetrahedron of four nodes: constant strain. Stiff in bending; prefer tetra10."""

from __future__ import annotations

from supple.fem.quadrature import centroid_tetrahedron, four_point_tetrahedron
from supple.fem.solid_element import SolidElement
from supple.mesh.cell_type import CellType

TETRA4_ELEMENT = SolidElement(CellType.TETRA4, centroid_tetrahedron(), four_point_tetrahedron())
