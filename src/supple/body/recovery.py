"""Recovery: displacements of interior points of a condensed model from its freedoms, by a matrix T.

    u_points = T [u_boundary; eta],      T R = R_points

Stiffness and mass do not contain the direction in which modal coordinates eta move the mass. Masses at the
points and nodes supply it. These masses are fitted to the mass matrix M of the body, scaled by its diagonal.
With the translations T_a and rotations Theta_a of point or node a per unit of the freedoms:

    M  ~  sum_a m_a T_a^T T_a + sum_a J_a Theta_a^T Theta_a,      m_a, J_a >= 0
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy  # its parts are imported when first used
from numpy.typing import NDArray
from scipy import sparse

from supple.arrays import FloatArray
from supple.body.mass_properties import rigid_mass_properties
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError

__all__ = ["Recovery"]

# Largest accepted deviation of the points from rigid motion, relative to the size of the body in rotations.
# Matrices printed with few digits stay below this value.
_MOVES_RIGIDLY = 1e-4
# With more masses of nodes and points in total, no masses are fitted.
_MOST_MASSES = 1500
# Largest accepted relative error of the fitted total mass, and error of the centre of mass relative to the
# radius of gyration. With larger errors the masses are not used.
_LARGEST_MISS = 0.05


@dataclass(frozen=True, eq=False)
class Recovery:
    """Displacements of points from the freedoms of a condensed model.

    points : (P, 3), m;  ids : (P,) ids of the points in the file
    matrix : (3 P, n) ux uy uz of each point, from the freedoms of the nodes, then the modal coordinates
    """

    points: FloatArray
    ids: NDArray[np.int64]
    matrix: FloatArray

    def check(self, body: str, nodes: FloatArray, dofs_per_node: int, n: int) -> None:
        """Raise ModelError for a matrix of the wrong size, or points that do not move rigidly with the nodes.

        body : name of the body, for the message;  n : number of freedoms, with modal coordinates
        """
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
                f"body '{body}': the recovery matrix deviates from rigid motion by {miss[worst]:.1e} at "
                f"point {self.ids[worst // 3]} u{'xyz'[worst % 3]}; it needs absolute displacements in basic "
                "axes, and columns in the order of the matrices (boundary freedoms and modal coordinates)"
            )

    def masses(
        self, mass: FloatArray, nodes: FloatArray, dofs_per_node: int
    ) -> tuple[FloatArray, FloatArray] | None:
        """Masses and moments of inertia of the nodes (N, 1 or 2), and masses of the points (P,), or None.

        None for more than 1500 masses; if their sum differs from the body's mass by more than 5 %; or if
        their centre differs by more than 5 % of the radius of gyration (points in one part of the body).
        """
        n, n_nodes, parts = len(mass), len(nodes), dofs_per_node // 3
        if n_nodes * parts + len(self.points) > _MOST_MASSES:
            return None
        diagonal = np.diag(mass)
        scale = np.divide(1.0, np.sqrt(np.maximum(diagonal, 0.0)), out=np.zeros(n), where=diagonal > 0)
        scaled = scale[:, None] * mass * scale
        own = np.eye(n)[: n_nodes * dofs_per_node]
        shapes = np.concatenate([own, self.matrix]).reshape(-1, 3, n) * scale
        flat = shapes.reshape(-1, n)
        products = ((flat @ flat.T) ** 2).reshape(len(shapes), 3, len(shapes), 3).sum(axis=(1, 3))
        wanted = np.einsum("aij,aij->a", shapes, shapes @ scaled)
        values, vectors = np.linalg.eigh(products)
        kept = values > 1e-12 * values[-1]
        root = np.sqrt(values[kept])
        matrix, right = root[:, None] * vectors[:, kept].T, (vectors[:, kept].T @ wanted) / root
        found = scipy.optimize.nnls(matrix, right)[0]
        of_nodes, of_points = found[: n_nodes * parts].reshape(n_nodes, parts), found[n_nodes * parts :]
        whole = rigid_mass_properties(mass, nodes, dofs_per_node)
        arms = np.concatenate([nodes, self.points]) - whole.centre
        weights = np.concatenate([of_nodes[:, 0], of_points])
        radius = np.sqrt(np.trace(whole.inertia) / whole.mass)
        if abs(weights.sum() - whole.mass) > _LARGEST_MISS * whole.mass:
            return None
        if np.linalg.norm(weights @ arms) > _LARGEST_MISS * whole.mass * radius:
            return None
        return of_nodes, of_points

    def rows(self, dofs_per_node: int) -> sparse.csc_array:
        """The recovery matrix (P * dofs_per_node, n) of all freedoms of the points; rotations are zero."""
        k = len(self.points)
        wide = np.zeros((k, dofs_per_node, self.matrix.shape[1]))
        wide[:, :3] = self.matrix.reshape(k, 3, -1)
        return sparse.csc_array(wide.reshape(k * dofs_per_node, -1))
