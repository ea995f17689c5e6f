"""Mass of stations: removal of round-off, and factorisation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError

__all__ = ["cleaned_mass", "first_moments", "mass_factor"]

Array = NDArray[np.float64]

MASSLESS = 1e-10
"""Mass relative to the largest; a smaller one is zero."""
LARGEST_NEGATIVE = 1e-6
"""Largest magnitude of a negative mass, relative to the largest mass; a larger one is an error."""


def cleaned_mass(name: str, mass: Array, length: float) -> Array:
    """The mass matrix without small negative principal values; ModelError for larger ones, or no mass.

    length : m, scale of inertias to masses
    """
    scale = np.tile(np.repeat([1.0, 1.0 / length], 3), len(mass) // 6)
    values, vectors = np.linalg.eigh(mass * np.outer(scale, scale))
    largest = np.abs(values).max(initial=0.0)
    if values.size and values[0] < -LARGEST_NEGATIVE * largest:
        worst = int(np.argmax(np.abs(vectors[:, 0]))) // 6
        raise ModelError(
            f"line '{name}': its mass is negative at station {worst}: the smallest principal value is "
            f"{values[0]:.3g} kg, with the mean segment as radius; the largest is {largest:.3g}. "
            "Export the mass matrix again, or correct the inertias"
        )
    if not largest > 0:
        raise ModelError(f"line '{name}': it has no mass: give its stations or elements mass")
    if values[0] >= 0:
        return mass
    kept = values > MASSLESS * largest
    root = (vectors[:, kept] * np.sqrt(values[kept])) / scale[:, None]
    return root @ root.T


def mass_factor(mass: Array, length: float) -> Array:
    """F (6 n, r) with F F^T = M; one column per freedom with mass."""
    scale = np.tile(np.repeat([1.0, 1.0 / length], 3), len(mass) // 6)
    scale = np.append(scale, np.ones(max(len(mass) - len(scale), 0)))
    values, vectors = np.linalg.eigh(mass * np.outer(scale, scale))
    kept = values > MASSLESS * values.max(initial=0.0)
    return (vectors[:, kept] * np.sqrt(values[kept])) / scale[:, None]


def first_moments(masses: Array) -> Array:
    """First moments (n, 3) of rigid masses (n, 6, 6), or of their first three columns, about their points."""
    return np.stack([masses[:, 5, 1], masses[:, 3, 2], masses[:, 4, 0]], axis=1)
