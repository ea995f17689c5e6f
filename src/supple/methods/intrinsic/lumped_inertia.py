"""Inertia of a body lumped on the stations of its line, with exact mass, first and second moments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.algebra import read_only
from supple.algebra.cross import cross_matrices
from supple.fem import CellMass, FiniteElementModel, cell_masses
from supple.methods.intrinsic.expansion import shares_of_stations
from supple.methods.intrinsic.load_path_tree import LoadPathTree

__all__ = ["lumped_inertia"]

Array = NDArray[np.float64]


def lumped_inertia(tree: LoadPathTree, model: FiniteElementModel) -> Array:
    """Mass (n, 6, 6) of each station, for velocity and angular velocity there.

    Every cell is rigidly attached to the two nearest stations, with weights that are linear along the
    segment. Each block is the inertia of a rigid mass, so none is negative. Their sum equals the
    consistent mass of the elements in any rigid motion.

        M_i = sum_e w_ie R_ie^T M_e R_ie

    w_ie are weights, M_e is the mass of cell e, and R_ie the rigid motion of its nodes by that of station i.
    """
    blocks = np.zeros((tree.n, 6, 6))
    for mass in cell_masses(model):
        corners = model.mesh.nodes[mass.nodes]
        stations, weights = shares_of_stations(tree, corners.mean(axis=1))
        for end in range(2):
            own = _rigid_inertia(mass, corners - tree.points[stations[:, end], None])
            np.add.at(blocks, stations[:, end], weights[:, end, None, None] * own)
    return read_only(0.5 * (blocks + blocks.swapaxes(1, 2)))


def _rigid_inertia(mass: CellMass, arms: Array) -> Array:
    """R^T M_e R (E, 6, 6) of cells about points from which their nodes have arms (E, k, 3)."""
    m = mass.translational
    total = m.sum(axis=(1, 2))
    first = np.einsum("eab,ebi->ei", m, arms)
    second = np.einsum("eab,eai,ebj->eij", m, arms, arms, optimize=True)
    result = np.zeros((len(arms), 6, 6))
    eye = np.eye(3)
    result[:, :3, :3] = total[:, None, None] * eye
    result[:, :3, 3:] = -cross_matrices(first)
    result[:, 3:, :3] = cross_matrices(first)
    result[:, 3:, 3:] = np.trace(second, axis1=1, axis2=2)[:, None, None] * eye - second
    if mass.rotary is not None:
        result[:, 3:, 3:] += mass.rotary.sum(axis=(1, 2))[:, None, None] * eye
    if mass.coupled is not None:
        rigid = np.zeros((*arms.shape[:2], 6, 6))
        rigid[:] = np.eye(6)
        rigid[:, :, :3, 3:] = -cross_matrices(arms.reshape(-1, 3)).reshape(*arms.shape[:2], 3, 3)
        rigid = rigid.reshape(len(arms), -1, 6)
        result += rigid.swapaxes(1, 2) @ mass.coupled @ rigid
    return result
