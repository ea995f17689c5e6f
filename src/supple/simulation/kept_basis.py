"""The basis of a reduced body on the coordinates of the full one, from the nodal motion that it keeps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from supple.body.full_body import FullBody
from supple.errors import ModelError
from supple.machine import System
from supple.reduction import ReducedBody, ReductionBasis

__all__ = ["kept_bases", "kept_basis"]

DIFFERENT = 1e-8
"""Of the nodal motion: what cannot be a motion of the full body."""
LIKE = 1e-6
"""Of the reduced stiffness: what that of the full body may differ by."""


def kept_basis(full: FullBody, reduced: ReducedBody) -> ReductionBasis:
    """V with T V = nodal basis: least squares, exact for a body reduced from this one.

    Raises ModelError for a body that was reduced from another, or has coordinates that no node shows.
    """
    if full.body.n_modal:
        raise ModelError(
            f"body '{full.name}' was condensed elsewhere, and its nodes do not show its modal "
            "coordinates, so nothing tells which a basis kept. Keep all: "
            'CompleteBasis(), or reduction = { basis = "complete" }'
        )
    T = full.body.expansion
    normal = splu(csc_array(T.T @ T))
    columns = normal.solve(np.asarray(T.T @ reduced.nodal_basis))
    left = np.abs(T @ columns - reduced.nodal_basis).max()
    stiffness = columns.T @ (full.body.stiffness @ columns)
    stiffer = np.abs(stiffness - reduced.stiffness).max() > LIKE * np.abs(reduced.stiffness).max()
    if stiffer or left > DIFFERENT * np.abs(reduced.nodal_basis).max():
        raise ModelError(
            f"body '{full.name}' in full is not the one that was reduced: "
            "their motions or their stiffness differ"
        )
    return ReductionBasis(reduced.frame, columns, reduced.report)


def kept_bases(system: System, fulls: Mapping[str, FullBody]) -> dict[str, ReductionBasis]:
    """Those of the reduced bodies of a machine of which the full ones are known, by name."""
    reduced = system.bodies_of(ReducedBody)
    return {name: kept_basis(fulls[name], body) for name, body in reduced.items() if name in fulls}
