"""Reference cells: node coordinates, shape functions and their gradients on the parents of solid cells."""

from __future__ import annotations

from functools import cache

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.mesh.cell_type import CellType

_CORNERS = {
    4: ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    5: ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 1)),
    6: ((0, 0, -1), (1, 0, -1), (0, 1, -1), (0, 0, 1), (1, 0, 1), (0, 1, 1)),
    8: (
        (-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1),
        (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1),
    ),
}  # fmt: skip
"""Corners of the parents of tetrahedron, pyramid, wedge and hexahedron, by number of corners."""


@cache
def reference_nodes(cell_type: CellType) -> FloatArray:
    """Parent coordinates (k, 3) of the nodes; read-only.

    The parents: the unit tetrahedron; the pyramid of height 1 over the square [-1, 1]^2; the wedge of the
    unit triangle over [-1, 1]; the cube [-1, 1]^3.
    """
    nodes = np.array(_CORNERS[cell_type.n_corners], dtype=np.float64)
    if cell_type.n_nodes > cell_type.n_corners:
        nodes = np.vstack([nodes, nodes[np.array(cell_type.edges)].mean(axis=1)])
    nodes.setflags(write=False)
    return nodes


@cache
def mirrored_order(cell_type: CellType) -> IntArray:
    """Node order of a mirrored cell; solids: that of the parent with x and y exchanged."""
    if cell_type.dimension < 3:
        return np.array([0, 1] if cell_type.dimension == 1 else [0, 2, 1])
    points = reference_nodes(cell_type)
    return np.argmin(np.linalg.norm(points[None] - points[:, None, [1, 0, 2]], axis=2), axis=1)


def shape_functions(cell_type: CellType, points: FloatArray) -> FloatArray:
    """Shape functions N_a (p, k) of a solid cell at parent points (p, 3), as in `shape_gradients`."""
    exponents = _exponents(cell_type)
    return _powers(points, exponents) @ np.linalg.inv(_powers(reference_nodes(cell_type), exponents))


def shape_gradients(cell_type: CellType, points: FloatArray) -> FloatArray:
    """Gradients dN_a/dxi_i of a solid cell's shape functions at parent points.

    N_a is one at node a and zero at the other nodes. With the functions p_m of the cell (see `_exponents`):
        N(xi) = p(xi) P^-1,   P_am = p_m(xi_a)

    Parameters
    ----------
    cell_type : CellType             a solid type
    points : float array (p, 3)      parent coordinates; not the apex of a pyramid, where no gradient exists
    Returns
    -------
    float array (p, k, 3)            index a the node, i the parent direction
    """
    exponents = _exponents(cell_type)
    P = _powers(reference_nodes(cell_type), exponents)
    dp = np.empty((len(points), len(exponents), 3))
    for i in range(3):
        lowered = exponents.copy()
        lowered[:, i] = np.maximum(lowered[:, i] - 1, 0)
        dp[:, :, i] = exponents[:, i] * _powers(points, lowered)
    raised = exponents + np.array([0, 0, 0, 1])
    dp[:, :, 2] += exponents[:, 3] * _powers(points, raised)
    return np.einsum("pmi,ma->pai", dp, np.linalg.inv(P))


def _powers(points: FloatArray, exponents: IntArray) -> FloatArray:
    """x^i y^j z^k / (1 - z)^l (p, m) of exponents (m, 4); zero at the apex z = 1 for l > 0, where x y = 0."""
    below_apex = 1.0 - points[:, 2:]
    divided = np.divide(1.0, below_apex, out=np.zeros_like(below_apex), where=below_apex != 0.0)
    return np.prod(np.hstack([points, divided])[:, None, :] ** exponents[None, :, :], axis=2)


def _exponents(cell_type: CellType) -> IntArray:
    """Exponents (k, 4) of the functions of a cell.

    Tetrahedra have the complete polynomials of degree 1 or 2, hexahedra and wedges the serendipity
    polynomials. Pyramids have the complete polynomials, x y / (1 - z) and, for degree 2, x and y times this
    function. These rational functions are of the same degree on every face and make the cell compatible with
    its neighbours.
    Source: G. Bedrosian, "Shape functions and integration formulas for three-dimensional finite element
    analysis", Int. J. Numer. Methods Eng. 35 (1992) 95-108.
    """
    grid = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    degree = 2 if cell_type.n_nodes > cell_type.n_corners else 1
    total, in_triangle = grid.sum(axis=1), grid[:, :2].sum(axis=1)
    rational = np.empty((0, 4), dtype=np.int64)
    match cell_type.n_corners:
        case 4:
            kept = total <= degree
        case 5:
            kept = total <= degree
            rational = np.array([(1, 1, 0, 1), (2, 1, 0, 1), (1, 2, 0, 1)])[: 2 * degree - 1]
        case 6:
            kept = (in_triangle <= degree) & (grid[:, 2] <= 1) | (in_triangle <= 1) & (grid[:, 2] <= degree)
        case _:
            # Serendipity: a linear factor counts nothing, a square counts two (Arnold and Awanou 2011).
            kept = np.where(grid > 1, grid, 0).sum(axis=1) <= (2 if degree == 2 else 0)
    polynomial = np.column_stack([grid[kept], np.zeros(kept.sum(), dtype=np.int64)])
    return np.vstack([polynomial, rational])
