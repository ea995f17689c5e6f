"""Condensed models with one boundary grid: its stiffness is zero, and rounding errors in it are removed."""

from __future__ import annotations

import numpy as np
from scipy import linalg, sparse

ROUNDING = 1e-6
"""Largest force on the boundary grid that counts as rounding, relative to that of inertia at the lowest modal
frequency, `omega^2 M`: the grid would resist rigid motion at a thousandth of that frequency."""


def freed_boundary(
    stiffness: sparse.csc_array,
    mass: sparse.csc_array,
    damping: sparse.csc_array | None,
    *,
    n_nodes: int,
    dofs_per_node: int,
) -> tuple[sparse.csc_array, sparse.csc_array | None]:
    """Stiffness and damping of a condensed model, without rounding errors in the rows of its only grid.

    Every motion of a single grid with six freedoms is rigid, so its rows are zero. Programs write the
    difference of large forces instead, which is not small relative to other entries of these rows. Larger
    entries, and the matrices of other models, are returned unchanged.
    """
    n = stiffness.indptr.size - 1
    if n_nodes != 1 or dofs_per_node != 6 or n <= 6 or mass.shape != stiffness.shape:
        return stiffness, damping
    inertia, modal, M = mass.diagonal()[:6], stiffness[6:, 6:].toarray(), mass[6:, 6:].toarray()
    try:
        lowest = float(linalg.eigvalsh(modal, M, subset_by_index=(0, 0))[0])
    except (linalg.LinAlgError, ValueError):  # no positive mass, or no finite number: the body checks both
        return stiffness, damping
    if lowest <= 0 or not (inertia > 0).all():
        return stiffness, damping
    size = np.sqrt(np.concatenate([lowest * inertia, np.maximum(np.diag(modal), 0.0)]))
    limit = ROUNDING * np.outer(size[:6], size)
    K = _freed(stiffness, limit)
    return K, None if damping is None else _freed(damping, limit / np.sqrt(lowest))


def _freed(matrix: sparse.csc_array, limit: np.ndarray) -> sparse.csc_array:
    """The matrix without entries of the grid up to the limit (6, n)."""
    entries = matrix.toarray()
    entries[:6][abs(entries[:6]) <= limit] = 0.0
    entries[:, :6][abs(entries[:, :6]) <= limit.T] = 0.0
    return sparse.csc_array(entries)
