"""Quadrature on the parent cells: the cube [-1, 1]^3 and the unit tetrahedron."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.special import roots_jacobi, roots_legendre

FloatArray = NDArray[np.float64]


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
    points = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3)
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
    # Gauss-Jacobi in each collapsed direction takes up the Jacobian (1 - t)^2 (1 - u).
    (r, wr), (s, ws), (t, wt) = (roots_jacobi(n, power, 0) for power in (2, 1, 0))
    r, s, t = ((1 + x) / 2 for x in (r, s, t))
    wr, ws, wt = wr / 8, ws / 4, wt / 2
    R, S, T = np.meshgrid(r, s, t, indexing="ij")
    points = np.stack([R, (1 - R) * S, (1 - R) * (1 - S) * T], axis=-1).reshape(-1, 3)
    return Quadrature(points, np.einsum("i,j,k->ijk", wr, ws, wt).ravel())
