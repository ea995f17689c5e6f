"""Infinitesimal rigid motion of nodes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


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
    x, y, z = np.moveaxis(vectors, -1, 0)
    o = np.zeros_like(x)
    rows = [[o, z, -y], [-z, o, x], [y, -x, o]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


# Nodes are collinear if their spread normal to the best-fit line is at most this fraction of the spread along
# the line.
COLLINEAR = 1e-6


def are_collinear(points: NDArray[np.float64]) -> bool:
    """Whether the points (k, 3) lie on one line or at one point."""
    arms = points - points.mean(axis=0)
    spread = np.linalg.svd(np.vstack([arms, np.zeros((2, 3))]), compute_uv=False)
    return bool(spread[1] <= COLLINEAR * spread[0])
