"""Hexahedron of twenty nodes (serendipity), with fourteen strain points.

Eight points would leave six modes without energy; fourteen have full rank at half the cost of twenty-seven.
"""

from __future__ import annotations

from supple.fem.quadrature import gauss_cube, irons_cube
from supple.fem.solid_element import SolidElement
from supple.mesh.cell_type import CellType

# With curved sides the inertia integrand x^2 det J has degree 4 + 5 in each direction.
HEXA20_ELEMENT = SolidElement(CellType.HEXA20, irons_cube(), gauss_cube(5))
