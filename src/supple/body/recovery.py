"""Recovery: points inside a condensed model, whose displacements follow its freedoms by a matrix.

u_points = T [u_boundary; eta],      T R = R_points
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError

__all__ = ["Recovery"]

FloatArray = NDArray[np.float64]

# Of a rigid motion, against the size of the body: rounding of matrices printed with few digits.
_MOVES_RIGIDLY = 1e-4


@dataclass(frozen=True, eq=False)
class Recovery:
    """Displacements of points from the freedoms of a condensed model.

    points : (P, 3), m;  ids : (P,) labels
    matrix : (3 P, n) ux uy uz of each point by the freedoms of the nodes and the modal coordinates
    """

    points: FloatArray
    ids: NDArray[np.int64]
    matrix: FloatArray

    def check(self, body: str, nodes: FloatArray, dofs_per_node: int, n: int) -> None:
        """ModelError for matrices of another size, or such as do not move rigidly with the nodes."""
        if self.matrix.shape != (3 * len(self.points), n):
            raise ModelError(
                f"body '{body}': the recovery matrix has shape {self.matrix.shape}; {len(self.points)} "
                f"points and {n} freedoms need ({3 * len(self.points)}, {n}): ux uy uz of each point"
            )
        R = nodal_rigid_modes(nodes, dofs_per_node)
        wanted = nodal_rigid_modes(self.points, 3)
        found = self.matrix[:, : len(R)] @ R
        middle = nodes.mean(axis=0)
        size = np.abs(np.concatenate([nodes, self.points]) - middle).max()
        scale = np.where(np.arange(6) < 3, 1.0, max(size, np.abs(middle).max()))
        miss = (np.abs(found - wanted) / scale).max(axis=1)
        worst = int(np.argmax(miss)) if miss.size else 0
        if miss.size and not miss[worst] <= _MOVES_RIGIDLY:  # NaN fails too
            raise ModelError(
                f"body '{body}': the recovery matrix misses rigid motion by {miss[worst]:.1e} at "
                f"point {self.ids[worst // 3]} u{'xyz'[worst % 3]}; give it for absolute displacements, its "
                "columns in the order of the matrices, boundary freedoms and modal coordinates alike, in "
                "basic axes"
            )

    def rows(self, dofs_per_node: int) -> sparse.csc_array:
        """The matrix (P * dofs_per_node, n), zero for rotations."""
        k = len(self.points)
        wide = np.zeros((k, dofs_per_node, self.matrix.shape[1]))
        wide[:, :3] = self.matrix.reshape(k, 3, -1)
        return sparse.csc_array(wide.reshape(k * dofs_per_node, -1))
