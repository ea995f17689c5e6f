"""Hourglass vectors of the eight-node hexahedron with one strain point.

    gamma_a = h_a - sum_i (h_a . X_i) b_i,      a = xi eta, eta zeta, zeta xi, xi eta zeta

with the corner pattern h_a and the mean gradient b. gamma_a is orthogonal to every affine motion. So the
amplitudes gamma_a . x rotate with the element, and their energy 1/2 kappa |gamma_a . x|^2 is invariant under
rotations.

Source: D. P. Flanagan, T. Belytschko, "A uniform strain hexahedron and quadrilateral with orthogonal
hourglass control", Int. J. Numer. Methods Eng. 17 (1981) 679-706.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.mesh import CellType
from supple.mesh.reference_cell import reference_nodes

__all__ = ["hourglass_vectors"]

FloatArray = NDArray[np.float64]


def hourglass_vectors(corners: FloatArray, gradient: FloatArray) -> FloatArray:
    """Vectors gamma (E, 4, 8) of cells with corners (E, 8, 3) and mean gradient (E, 3, 8)."""
    xi, eta, zeta = reference_nodes(CellType.HEXA8).T
    patterns = np.stack([xi * eta, eta * zeta, zeta * xi, xi * eta * zeta])
    return patterns - np.einsum("ak,eki,eil->eal", patterns, corners, gradient, optimize=True)
