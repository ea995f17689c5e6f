"""DMIG punch files (.pch): symmetric real matrices of a body, as Nastran and Radioss read them.

    DMIG*   KAAX                           1               1
    *                      1               1 1.234567890D+05

A field has sixteen columns. A column of the matrix has a header card (DMIG*), and one card for each of its
nonzero entries in the lower triangle.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from supple.errors import ModelError
from supple.export.ascii_file import write_ascii
from supple.importers.plain_number import in_sixteen_columns

__all__ = ["dmig_cards", "write_dmig_punch"]

Matrix = NDArray[np.float64] | sparse.sparray

_SYMMETRIC, _REAL_DOUBLE = 6, 2


def write_dmig_punch(path: Path | str, node_ids: ArrayLike, dofs_per_node: int, **matrices: Matrix) -> Path:
    """Write matrices under the names of their arguments (KAAX=stiffness, MAAX=mass); returns the path.

    node_ids : (N,) ids of the grids;   dofs_per_node : 3 or 6, components 1 to 3 or 6
    matrices : (n, n) symmetric, sparse or dense, n = N * dofs_per_node; names have at most eight characters
    Raises ModelError: no matrix; a longer name; a matrix of another size, not symmetric or not finite.
    Raises ResultFileError: the file cannot be written.
    """
    ids = np.asarray(node_ids)
    components = np.tile(np.arange(1, dofs_per_node + 1), len(ids))
    lines = dmig_cards(np.column_stack([np.repeat(ids, dofs_per_node), components]), matrices)
    return write_ascii(path, lines)


def dmig_cards(freedoms: ArrayLike, matrices: Mapping[str, Matrix]) -> list[str]:
    """The DMIG cards of named matrices.

    freedoms : (n, 2) grid and component of each row; component 0 for a scalar point

    Raises ModelError as for `write_dmig_punch`.
    """
    labels = np.asarray(freedoms)
    n = len(labels)
    if not matrices:
        raise ModelError("a DMIG file needs a matrix: KAAX=body.stiffness")
    lines = []
    for name, given in matrices.items():
        matrix = sparse.csc_array(given)
        if matrix.shape != (n, n):
            raise ModelError(f"{name} has shape {matrix.shape}; {n} degrees of freedom need ({n}, {n})")
        if len(name) > 8 or not np.isfinite(matrix.data).all():
            raise ModelError(f"{name}: a DMIG needs finite entries and a name of at most eight characters")
        if abs(matrix - matrix.T).max() > 1e-9 * abs(matrix).max():
            raise ModelError(
                f"{name} is not symmetric, and Radioss reads symmetric matrices only: give (A + A.T) / 2"
            )
        lines.append(f"DMIG    {name:<8}{0:8d}{_SYMMETRIC:8d}{_REAL_DOUBLE:8d}{0:8d}")
        lower = sparse.csc_array(sparse.tril(matrix))
        lower.eliminate_zeros()
        for j in np.flatnonzero(np.diff(lower.indptr)):
            lines.append(f"DMIG*   {name:<16}{labels[j, 0]:16d}{labels[j, 1]:16d}")
            for at in range(lower.indptr[j], lower.indptr[j + 1]):
                i, value = lower.indices[at], lower.data[at]
                number = in_sixteen_columns(value).replace("E", "D")
                lines.append(f"*       {labels[i, 0]:16d}{labels[i, 1]:16d}{number}")
    return lines
