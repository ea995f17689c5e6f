"""Reference cells: node coordinates and shape-function gradients on the parent tetrahedron and cube."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from supple.mesh.cell_type import CellType

_TETRA_CORNERS = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
_HEXA_CORNERS = (
    (-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1),
    (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1),
)  # fmt: skip


@cache
def reference_nodes(cell_type: CellType) -> NDArray[np.float64]:
    """Parent coordinates (k, 3) of the nodes: unit tetrahedron, or the cube [-1, 1]^3; read-only."""
    corners = np.array(_TETRA_CORNERS if cell_type.n_corners == 4 else _HEXA_CORNERS, dtype=np.float64)
    nodes = corners
    if cell_type.n_nodes > cell_type.n_corners:
        nodes = np.vstack([corners, corners[np.array(cell_type.edges)].mean(axis=1)])
    nodes.setflags(write=False)
    return nodes


def shape_functions(cell_type: CellType, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shape functions N_a (p, k) of a solid cell at parent points (p, 3): N(xi) = p(xi) P^-1."""
    exponents = _monomials(cell_type)
    return _powers(points, exponents) @ np.linalg.inv(_powers(reference_nodes(cell_type), exponents))


def shape_gradients(cell_type: CellType, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Gradients dN_a/dxi_i of a solid cell's shape functions at parent points.

    The N_a span the monomials of the cell and are one at their own node, zero at the others:
        N(xi) = p(xi) P^-1,   P_am = p_m(xi_a)

    Parameters
    ----------
    cell_type : CellType             a solid type
    points : float array (p, 3)      parent coordinates
    Returns
    -------
    float array (p, k, 3)            index a the node, i the parent direction
    """
    exponents = _monomials(cell_type)
    P = _powers(reference_nodes(cell_type), exponents)
    dp = np.empty((len(points), len(exponents), 3))
    for i in range(3):
        lowered = exponents.copy()
        lowered[:, i] = np.maximum(lowered[:, i] - 1, 0)
        dp[:, :, i] = exponents[:, i] * _powers(points, lowered)
    return np.einsum("pmi,ma->pai", dp, np.linalg.inv(P))


def _powers(points: NDArray[np.float64], exponents: NDArray[np.int64]) -> NDArray[np.float64]:
    return np.prod(points[:, None, :] ** exponents[None, :, :], axis=2)


def _monomials(cell_type: CellType) -> NDArray[np.int64]:
    """Exponents (k, 3): complete degree 1 or 2 on a tetrahedron; on a cube, superlinear degree 1 or 2."""
    grid = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    quadratic = cell_type.n_nodes > cell_type.n_corners
    if cell_type.n_corners == 4:
        return grid[grid.sum(axis=1) <= (2 if quadratic else 1)]
    # Serendipity: a linear factor costs nothing, a square costs two (Arnold and Awanou 2011).
    superlinear = np.where(grid > 1, grid, 0).sum(axis=1)
    return grid[superlinear <= (2 if quadratic else 0)]
