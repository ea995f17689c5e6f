"""Hexahedron of eight nodes, fully integrated: stiff in bending when its cells are slender; prefer hexa20."""

from __future__ import annotations

from supple.fem.quadrature import gauss_cube
from supple.fem.solid_element import SolidElement
from supple.mesh.cell_type import CellType

# The inertia integrand x^2 det J has degree 2 + 2 in each direction.
HEXA8_ELEMENT = SolidElement(CellType.HEXA8, gauss_cube(2), gauss_cube(3))
