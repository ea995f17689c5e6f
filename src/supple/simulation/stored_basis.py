"""The basis of a reduced body in the coordinates of its full body, from the stored nodal basis."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from supple.body import FlexibleBody, FullBody
from supple.errors import ModelError
from supple.machine import System
from supple.reduction import ReducedBody, ReductionBasis

DIFFERENT = 1e-8
"""Least-squares residual, relative to the nodal basis, above which `full` and `reduced` do not match."""
LIKE = 1e-6
"""Difference of the projected stiffness, relative to the reduced one, above which they do not match."""


def coordinates_of_nodes(body: FlexibleBody) -> Callable[[np.ndarray], np.ndarray]:
    """Function that finds the coordinates (n, ..) of nodal freedoms (n_nodal, ..), by least squares."""
    T = body.expansion
    normal = splu(csc_array(T.T @ T))
    return lambda nodal: normal.solve(np.asarray(T.T @ nodal))


def stored_basis(full: FullBody, reduced: ReducedBody) -> ReductionBasis:
    """The basis of `reduced` in the coordinates of `full`: V with T V = nodal basis, by least squares.

    T expands coordinates to nodal freedoms. V is exact if `reduced` is a reduction of `full`. Raises
    ModelError if it is not, or if `full` has modal coordinates, which have no nodal motion.
    """
    if full.body.n_modal:
        raise ModelError(
            f"body '{full.name}' is a condensed model, whose nodes do not show its modal "
            "coordinates, so the reduced basis is unknown in them. Keep all coordinates: "
            'CompleteBasis(), or reduction = { basis = "complete" }'
        )
    columns = coordinates_of_nodes(full.body)(reduced.nodal_basis)
    left = np.abs(full.body.expansion @ columns - reduced.nodal_basis).max()
    stiffness = columns.T @ (full.body.stiffness @ columns)
    stiffer = np.abs(stiffness - reduced.stiffness).max() > LIKE * np.abs(reduced.stiffness).max()
    if stiffer or left > DIFFERENT * np.abs(reduced.nodal_basis).max():
        raise ModelError(
            f"body '{full.name}' in full is not the one that was reduced: "
            "their motions or their stiffness differ. Give the full body of this reduction"
        )
    return ReductionBasis(reduced.frame, columns, reduced.report)


def stored_bases(system: System, fulls: Mapping[str, FullBody]) -> dict[str, ReductionBasis]:
    """Bases of a machine's reduced bodies with known full bodies, by name."""
    reduced = system.bodies_of(ReducedBody)
    return {name: stored_basis(fulls[name], body) for name, body in reduced.items() if name in fulls}
