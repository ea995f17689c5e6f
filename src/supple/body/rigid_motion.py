"""Infinitesimal rigid motion of nodes, and its best fit to their motion (averaging interfaces, RBE3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.algebra.cross import cross_matrices


def nodal_rigid_modes(nodes: NDArray[np.float64], dofs_per_node: int) -> NDArray[np.float64]:
    """Rigid modes (N * dofs_per_node, 6) about the mesh origin: translations e_i, rotations e_i x x_a."""
    modes = np.zeros((len(nodes), dofs_per_node, 6))
    modes[:, :3, :3] = np.eye(3)
    modes[:, :3, 3:] = cross_of_axes(nodes)
    if dofs_per_node == 6:
        modes[:, 3:, 3:] = np.eye(3)
    return modes.reshape(-1, 6)


def cross_of_axes(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrices (..., 3, 3) of the maps theta -> theta x v, with columns e_i x v; transposed: u -> v x u."""
    return np.swapaxes(cross_matrices(vectors), -1, -2)


# Nodes are collinear if their spread normal to the best-fit line is at most this fraction of the spread along
# the line.
COLLINEAR = 1e-6


def are_collinear(points: NDArray[np.float64]) -> bool:
    """Whether the points (k, 3) lie on one line or at one point."""
    arms = points - points.mean(axis=0)
    spread = np.linalg.svd(np.vstack([arms, np.zeros((2, 3))]), compute_uv=False)
    return bool(spread[1] <= COLLINEAR * spread[0])


def averaged_motion(
    points: NDArray[np.float64],
    weights: NDArray[np.float64],
    position: NDArray[np.float64],
    dofs_per_node: int,
) -> NDArray[np.float64]:
    """Linear map from the freedoms of weighted nodes to their least-squares rigid motion at a position.

        min  sum_a w_a |u_a - u - theta x r_a|^2,     r_a = x_a - centroid
        u = mean of u_a,     J theta = sum_a w_a r_a x u_a,     J = sum_a w_a (r_a.r_a I - r_a r_a^T)
        u_v = u + theta x (position - centroid),     theta_v = theta

    The nodes' displacements do not define the rotation of a single node, or about the line of collinear
    nodes; there theta is the weighted mean of the nodal rotations. A rigid motion is reproduced exactly;
    hence the transpose of the map distributes a force and a moment at the position over the nodes, with
    equal resultants.

    points   : (k, 3), not all on one line if dofs_per_node is 3
    weights  : (k,) positive
    position : (3,), where u_v is the displacement
    Returns (6, k, dofs_per_node): (u_v, theta_v) as a linear map of the nodes' freedoms.
    """
    shares = weights / weights.sum()
    centroid = shares @ points
    arms = points - centroid
    spread = (arms * shares[:, None]).T @ arms
    inertias, axes = np.linalg.eigh(np.trace(spread) * np.eye(3) - spread)
    resolved = inertias > COLLINEAR**2 * inertias[-1]

    motion = np.zeros((6, len(points), dofs_per_node))
    J_inverse = (axes[:, resolved] / inertias[resolved]) @ axes[:, resolved].T
    motion[:3, :, :3] = shares[:, None] * np.eye(3)[:, None, :]
    motion[3:, :, :3] = np.einsum("ij,a,ajk->iak", J_inverse, shares, cross_matrices(arms))
    if dofs_per_node == 6:
        unresolved = axes[:, ~resolved] @ axes[:, ~resolved].T
        motion[3:, :, 3:] = shares[:, None] * unresolved[:, None, :]
    motion[:3] += np.einsum("ij,jak->iak", cross_of_axes(position - centroid), motion[3:])
    return motion
