"""Rigid interfaces (RBE2): elimination of the nodes' freedoms in favour of a virtual node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.algebra.narrow_indices import narrow_indices
from supple.body.rigid_motion import nodal_rigid_modes


def rigid_elimination(
    nodes: NDArray[np.float64],
    dofs_per_node: int,
    rigid_sets: Sequence[tuple[NDArray[np.int64], NDArray[np.float64]]],
) -> sparse.csc_array:
    """The sparse expansion T, u_nodal = T q, with six coordinates for each rigid set.

        q = (freedoms of the nodes outside the sets in nodal order, then (u_v, theta_v) of each set)
        u_a = u_v + theta_v x (x_a - x_v),   theta_a = theta_v

    nodes      : (N, 3)
    rigid_sets : (node numbers (k,), position of the virtual node (3,)) each; no node in two of them
    Returns csc (N * dofs_per_node, n): n = (free nodes) * dofs_per_node + 6 * (sets).
    Source: Wu et al. 2019, Appendix B.
    """
    free = np.ones(len(nodes), dtype=bool)
    for node_ids, _ in rigid_sets:
        free[node_ids] = False
    kept = np.flatnonzero(np.repeat(free, dofs_per_node))
    rows, columns, entries = [kept], [np.arange(kept.size)], [np.ones(kept.size)]
    n = kept.size
    for node_ids, position in rigid_sets:
        block = nodal_rigid_modes(nodes[node_ids] - position, dofs_per_node)
        dofs = (node_ids[:, None] * dofs_per_node + np.arange(dofs_per_node)).ravel()
        row, column = np.nonzero(block)
        rows.append(dofs[row])
        columns.append(n + column)
        entries.append(block[row, column])
        n += 6
    triplets = (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns)))
    return narrow_indices(sparse.csc_array(triplets, shape=(len(nodes) * dofs_per_node, n)))
