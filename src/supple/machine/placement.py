"""Checks of the vectors and rotations that place bodies in space."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from supple.arguments import check_numbers
from supple.errors import ModelError

__all__ = ["rotation_matrix", "space_vector"]


def space_vector(what: str, value: object) -> np.ndarray:
    """The value as an array (3,), read-only.

    Raises ModelError unless it consists of three finite numbers; `what` names the quantity in the message.
    """
    check_numbers(what, value)
    array = np.array(value, dtype=float)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ModelError(f"{what} must be three finite numbers, got {value}")
    array.setflags(write=False)
    return array


def rotation_matrix(what: str, value: object) -> np.ndarray:
    """Rotation matrix (3, 3), read-only, from a rotation vector (3,), rad, or a matrix.

    Raises ModelError for another shape, or a matrix that is not orthonormal or has a negative determinant.
    """
    check_numbers(what, value)
    matrix = np.array(value, dtype=float)
    if matrix.shape == (3,):
        space_vector(what, matrix)
        matrix = Rotation.from_rotvec(matrix).as_matrix()
    if matrix.shape != (3, 3) or not np.allclose(matrix.T @ matrix, np.eye(3), atol=1e-9):
        raise ModelError(f"{what} must be a rotation vector (3,) or an orthonormal matrix (3, 3)")
    if np.linalg.det(matrix) < 0:
        raise ModelError(f"{what} mirrors the body (determinant -1): swap two columns")
    matrix.setflags(write=False)
    return matrix
