"""Interface operator H = D + U U^T, inverted by Woodbury's formula.

    H^-1 = D^-1 - D^-1 U (I + U^T D^-1 U)^-1 U^T D^-1

D belongs to the elements and is diagonal for matching meshes; U U^T belongs to the modes and has low rank.
For l interface freedoms and k modes, the inversion costs O(l k^2) operations, each solution O(l k). For
mortar rows D is full, and its inverse is stored as a matrix.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

__all__ = ["InterfaceOperator", "interface_operator"]


class InterfaceOperator(NamedTuple):
    """H^-1 = left - thin thin^T; left is D^-1, its diagonal (l,) or the matrix (l, l); thin is (l, k)."""

    left: Array
    thin: Array

    def solve(self, right: Array) -> Array:
        """H^-1 right (l,), for right (l,)."""
        first = self.left * right if self.left.ndim == 1 else self.left @ right
        return first - self.thin @ (self.thin.T @ right)


def interface_operator(
    element_part: NDArray[np.float64], modal_rows: NDArray[np.float64]
) -> InterfaceOperator:
    """The inverse of H = element_part + modal_rows modal_rows^T.

    element_part : (l, l) or its diagonal (l,), nonsingular;   modal_rows : (l, k)
    """
    diagonal = element_part if element_part.ndim == 1 else np.diag(element_part)
    is_diagonal = element_part.ndim == 1 or not (element_part - np.diag(diagonal)).any()
    left = 1 / diagonal if is_diagonal else np.linalg.inv(element_part)
    spread = left[:, None] * modal_rows if is_diagonal else left @ modal_rows
    inner = np.eye(modal_rows.shape[1]) + modal_rows.T @ spread
    thin = np.linalg.solve(np.linalg.cholesky(inner), spread.T).T
    return InterfaceOperator(jnp.asarray(left), jnp.asarray(thin))
