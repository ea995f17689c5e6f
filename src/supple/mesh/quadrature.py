"""Quadrature on the parents of solid cells (see `supple.mesh.reference_cell`)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from scipy.special import roots_jacobi, roots_legendre

from supple.arrays import FloatArray
from supple.mesh.cell_type import CellType


@dataclass(frozen=True, eq=False)
class Quadrature:
    """Points (p, 3) in parent coordinates and weights (p,) that sum to the parent volume; read-only."""

    points: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        self.points.setflags(write=False)
        self.weights.setflags(write=False)


def gauss_cube(n: int) -> Quadrature:
    """Gauss-Legendre product on the cube: n^3 points, exact to degree 2n - 1 in each direction."""
    x, w = roots_legendre(n)
    points = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1, dtype=np.float64).reshape(-1, 3)
    return Quadrature(points, np.einsum("i,j,k->ijk", w, w, w).ravel())


def irons_cube() -> Quadrature:
    """Fourteen points on the cube, exact to total degree 5.

    Source: B. M. Irons, "Quadrature rules for brick based finite elements", Int. J. Numer. Methods Eng. 3
    (1971) 293-294.
    """
    a, b = np.sqrt(19 / 30), np.sqrt(19 / 33)
    faces = a * np.concatenate([np.eye(3), -np.eye(3)])
    corners = b * np.array(list(product((-1, 1), repeat=3)))
    return Quadrature(np.concatenate([faces, corners]), np.repeat([320 / 361, 121 / 361], [6, 8]))


def reduced_cube() -> Quadrature:
    """The eight Gauss points on the cube with the factor 3/4, and the fourteen points of Irons with 1/4.

    Eight points alone leave six zero-energy modes of a HEXA20. In a row of single cells, some of these modes
    have lower frequencies than the bending modes if the factor on the fourteen points is too small. A quarter
    of the excess stiffness of full integration remains.
    """
    few, full = gauss_cube(2), irons_cube()
    share = 0.25
    return Quadrature(
        np.concatenate([few.points, full.points]),
        np.concatenate([(1 - share) * few.weights, share * full.weights]),
    )


def centroid_tetrahedron() -> Quadrature:
    """One point on the tetrahedron, exact to degree 1."""
    return Quadrature(np.full((1, 3), 1 / 4), np.array([1 / 6]))


def four_point_tetrahedron() -> Quadrature:
    """Four points on the tetrahedron, exact to degree 2 (Hammer, Marlowe and Stroud 1956)."""
    near, far = (5 - np.sqrt(5)) / 20, (5 + 3 * np.sqrt(5)) / 20
    points = np.full((4, 3), near)
    points[[1, 2, 3], [0, 1, 2]] = far
    return Quadrature(points, np.full(4, 1 / 24))


def conical_tetrahedron(n: int) -> Quadrature:
    """Product rule of n^3 points on the tetrahedron collapsed from a cube, exact to degree 2n - 1.

    Source: A. H. Stroud, Approximate Calculation of Multiple Integrals (1971), section 2.5.
    """
    # The Gauss-Jacobi weights in the collapsed directions include the Jacobian (1 - t)^2 (1 - u).
    (r, wr), (s, ws), (t, wt) = (roots_jacobi(n, power, 0) for power in (2, 1, 0))
    r, s, t = ((1 + x) / 2 for x in (r, s, t))
    wr, ws, wt = wr / 8, ws / 4, wt / 2
    R, S, T = np.meshgrid(r, s, t, indexing="ij")
    points = np.stack([R, (1 - R) * S, (1 - R) * (1 - S) * T], axis=-1).reshape(-1, 3)
    return Quadrature(points, np.einsum("i,j,k->ijk", wr, ws, wt).ravel())


def conical_wedge(n: int) -> Quadrature:
    """Product rule of n^3 points on the wedge: a collapsed triangle times a line, exact to degree 2n - 1."""
    (r, wr), (s, ws) = roots_jacobi(n, 1, 0), roots_legendre(n)
    R, S = np.meshgrid((1 + r) / 2, (1 + s) / 2, indexing="ij")
    triangle = np.stack([R, (1 - R) * S], axis=-1).reshape(-1, 2)
    return _prism(triangle, np.outer(wr / 4, ws / 2).ravel(), n)


def three_point_wedge(n: int) -> Quadrature:
    """Product rule on the wedge: three points in the triangle, exact to degree 2, times n points along it."""
    triangle = np.array([(1, 1), (4, 1), (1, 4)]) / 6
    return _prism(triangle, np.full(3, 1 / 6), n)


def conical_pyramid(n: int) -> Quadrature:
    """Product rule of n^3 points on the pyramid collapsed from a cube; exact also for x y / (1 - z).

    Source: A. H. Stroud, Approximate Calculation of Multiple Integrals (1971), section 2.5.
    """
    (x, wx), (z, wz) = roots_legendre(n), roots_jacobi(n, 2, 0)
    X, Y, Z = np.meshgrid(x, x, (1 + z) / 2, indexing="ij")
    points = np.stack([(1 - Z) * X, (1 - Z) * Y, Z], axis=-1).reshape(-1, 3)
    return Quadrature(points, np.einsum("i,j,k->ijk", wx, wx, wz / 8).ravel())


@cache
def strain_rule(kind: CellType) -> Quadrature:
    """Strain points of a solid cell: enough to exclude zero-energy modes other than rigid motion.

    Eight points would leave six zero-energy modes of a HEXA20; fourteen have full rank at half the cost of
    twenty-seven. A TETRA10 with straight sides has a linear strain, which four points integrate exactly.
    """
    rules = {
        CellType.TETRA4: centroid_tetrahedron,
        CellType.TETRA10: four_point_tetrahedron,
        CellType.PYRAMID5: lambda: conical_pyramid(2),
        CellType.PYRAMID13: lambda: conical_pyramid(3),
        CellType.WEDGE6: lambda: three_point_wedge(2),
        CellType.WEDGE15: lambda: three_point_wedge(3),
        CellType.HEXA8: lambda: gauss_cube(2),
        CellType.HEXA20: irons_cube,
    }
    return rules[kind]()


@cache
def product_rule(kind: CellType, n: int) -> Quadrature:
    """Product rule of n^3 points on the parent of a solid cell."""
    by_corners = {4: conical_tetrahedron, 5: conical_pyramid, 6: conical_wedge, 8: gauss_cube}
    return by_corners[kind.n_corners](n)


def _prism(triangle: FloatArray, weights: FloatArray, n: int) -> Quadrature:
    """Product rule on the wedge: points (p, 2) of a triangle times n Gauss points along the wedge."""
    z, w = roots_legendre(n)
    points = np.column_stack([np.repeat(triangle, n, axis=0), np.tile(z, len(triangle))])
    return Quadrature(points, np.outer(weights, w).ravel())
