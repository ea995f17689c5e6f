"""Frequencies of a free uniform beam by beam theory, as reference for solid models."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy import linalg

from supple.fem import Isotropic

__all__ = ["RoundBeam"]

# Legendre polynomials for each field: the lowest ten frequencies are then accurate to ten digits.
DEGREE = 30


@dataclass(frozen=True)
class RoundBeam:
    """A solid circular cylinder with free ends.

    length, radius : m
    """

    length: float
    radius: float
    material: Isotropic

    @property
    def shear_modulus(self) -> float:
        """G, Pa."""
        return self.material.youngs_modulus / (2 * (1 + self.material.poissons_ratio))

    @property
    def shear_coefficient(self) -> float:
        """Shear coefficient of a circular section: 6 (1 + nu)^2 / (7 + 12 nu + 4 nu^2). [Hutchinson2001]"""
        nu = self.material.poissons_ratio
        return 6 * (1 + nu) ** 2 / (7 + 12 * nu + 4 * nu**2)

    def torsion(self, n: int) -> np.ndarray:
        """Frequencies of n torsional modes, Hz: k c / (2 L), c = sqrt(G / rho). Exact in three dimensions."""
        speed = np.sqrt(self.shear_modulus / self.material.density)
        return np.arange(1, n + 1) * speed / (2 * self.length)

    def bending(self, n: int) -> np.ndarray:
        """Frequencies of n bending modes of a Timoshenko beam, Hz; each occurs in two directions.

        min  int EI psi'^2 + k G A (w' - psi)^2  over  int rho A w^2 + rho I psi^2

        by the Rayleigh-Ritz method with Legendre polynomials of high degree for both fields, ends free.
        """
        points, weights = legendre.leggauss(DEGREE + 2)
        values = legendre.legvander(points, DEGREE - 1)
        slopes = np.column_stack([legendre.legval(points, legendre.legder(row)) for row in np.eye(DEGREE)])
        slopes *= 2 / self.length
        weights = weights * self.length / 2
        area, inertia = np.pi * self.radius**2, np.pi * self.radius**4 / 4
        bending = self.material.youngs_modulus * inertia
        shear = self.shear_coefficient * self.shear_modulus * area

        def gram(left: np.ndarray, right: np.ndarray) -> np.ndarray:
            return left.T @ (weights[:, None] * right)

        K = np.block(
            [
                [shear * gram(slopes, slopes), -shear * gram(slopes, values)],
                [
                    -shear * gram(values, slopes),
                    bending * gram(slopes, slopes) + shear * gram(values, values),
                ],
            ]
        )
        mass = gram(values, values)
        M = self.material.density * linalg.block_diag(area * mass, inertia * mass)
        squares = linalg.eigh(K, M, eigvals_only=True)[2 : 2 + n]
        return np.sqrt(squares) / (2 * np.pi)
