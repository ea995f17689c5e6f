"""The six rigid links between the four points of a frame, as half squares: D = 1/2 (|x_I - x_J|^2 - L^2)."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax import Array

from supple.methods.explicit.frame_points import LINKS

__all__ = ["link_residual", "link_rows", "link_vectors"]

# NumPy, not JAX: a process that has only imported this module may still fork.
_SIGNS = np.eye(4)[LINKS[:, 0]] - np.eye(4)[LINKS[:, 1]]


def link_vectors(p: Array) -> Array:
    """Vectors d = x_I - x_J (6, 3) of points p (4, 3), or their rates from those of the points."""
    return jnp.asarray(_SIGNS) @ p


def link_residual(p: Array, squared_lengths: Array) -> Array:
    """Residuals D (6,), m^2."""
    d = link_vectors(p)
    return 0.5 * ((d * d).sum(axis=1) - squared_lengths)


def link_rows(vectors: Array) -> Array:
    """G = dD/dp (6, 12) for link vectors (6, 3)."""
    return (jnp.asarray(_SIGNS)[:, :, None] * vectors[:, None, :]).reshape(6, 12)
