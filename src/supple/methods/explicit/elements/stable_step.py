"""Stable step of explicit elements: no mode of a mesh is faster than the fastest of its single elements.

    omega_max(M, K) <= max_e omega_max(M_e, K_e),   dt <= 2 / omega_max       (Irons and Treharne 1971)

At rest, the largest eigenvalue of each element is exact, from A A^T with A = sqrt(V) D^(1/2) B M_e^(-1/2),
six rows per strain point. The hourglass stiffness adds at most its own eigenvalue. For deformed elements, the
limit is multiplied by the smallest stretch, divided by sqrt(det F) where the volume has grown.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from supple.fem import Isotropic
from supple.methods.explicit.elements.mean_gradient import SolidPoints
from supple.methods.explicit.elements.solid_block import SolidBlock, deformation
from supple.methods.explicit.tensor3 import as_array

__all__ = ["element_limits", "smallest_stretch"]

FloatArray = NDArray[np.float64]


def element_limits(
    points: SolidPoints, masses: FloatArray, elastic: Isotropic, hourglass: FloatArray
) -> FloatArray:
    """2 / omega_max of each element at rest, (E,), s.

    masses : (E, k) lumped, kg;   hourglass : (E,) kappa, N/m
    """
    root = np.linalg.cholesky(elastic.elasticity).T
    g = points.gradients / np.sqrt(masses)[:, None, None, :]
    E, n_points, _, k = g.shape
    B = np.zeros((E, n_points, 6, k, 3))
    for i in range(3):
        B[:, :, i, :, i] = g[:, :, i]
    for row, (i, j) in enumerate(((1, 2), (0, 2), (0, 1)), start=3):
        B[:, :, row, :, i] = g[:, :, j]
        B[:, :, row, :, j] = g[:, :, i]
    A = (root @ B.reshape(E, n_points, 6, 3 * k)) * np.sqrt(points.volumes)[:, :, None, None]
    A = A.reshape(E, 6 * n_points, 3 * k)
    largest = np.linalg.eigvalsh(A @ A.swapaxes(1, 2))[:, -1]
    if points.gamma.shape[1]:
        gamma = points.gamma / np.sqrt(masses)[:, None]
        largest = largest + hourglass * np.linalg.eigvalsh(gamma @ gamma.swapaxes(1, 2))[:, -1]
    return 2 / np.sqrt(largest)


def smallest_stretch(block: SolidBlock, x: Array) -> Array:
    """Factor (E,) on the limits at rest: smallest stretch / max(1, sqrt(det F)), at positions x (3, N)."""
    F = as_array(deformation(block, x[:, block.nodes]))
    C = jnp.einsum("kige,kjge->geij", F, F)
    stretch = jnp.sqrt(jnp.maximum(jnp.linalg.eigvalsh(C)[..., 0], 0.0))
    volume = jnp.sqrt(jnp.maximum(jnp.linalg.det(C), 0.0)) ** 0.5
    return jnp.minimum(stretch, stretch / jnp.maximum(volume, 1e-30)).min(axis=0)
