"""Cross products as matrices, for NumPy arrays; `rotation.skew` is the one for compiled code."""

from __future__ import annotations

import numpy as np


def cross_matrix(w: np.ndarray) -> np.ndarray:
    """`skew(w)`, (3, 3): `skew(w) v = w x v`."""
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def cross_matrices(vectors: np.ndarray) -> np.ndarray:
    """`skew(v)` of vectors (..., 3), (..., 3, 3)."""
    result = np.zeros((*vectors.shape, 3))
    x, y, z = np.moveaxis(vectors, -1, 0)
    result[..., 0, 1], result[..., 0, 2], result[..., 1, 2] = -z, y, -x
    result[..., 1, 0], result[..., 2, 0], result[..., 2, 1] = z, -y, x
    return result
