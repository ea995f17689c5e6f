"""Linear rotations of the material of a model, from the nodal freedoms."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csc_array

from supple.fem.model import SOLID_ELEMENTS, FiniteElementModel, nodal_freedoms
from supple.fem.solid_element import solid_rotation

__all__ = ["nodal_rotation_operator"]


def nodal_rotation_operator(model: FiniteElementModel) -> csc_array:
    """Operator (3 P, n) that gives the rotation vector at P points from the nodal freedoms.

    Shells, beams and rods with torsion: the rotational freedoms of their nodes. Solids: half the curl of u at
    the centre of each cell. Other rods: none.
    """
    d = model.dofs_per_node
    rotation, row, column = [np.empty(0)], [np.empty(0, int)], [np.empty(0, int)]
    n_rows = 0
    if d == 6:
        sheets = [section.nodes(model.mesh) for section in model.sections if section.turns_nodes()]
        turning = (
            np.unique(np.concatenate([nodes.ravel() for nodes in sheets])) if sheets else np.empty(0, int)
        )
        n_rows = 3 * len(turning)
        rotation, row = [np.ones(n_rows)], [np.arange(n_rows)]
        column = [(6 * turning[:, None] + np.arange(3, 6)).ravel()]
    for section in model.sections:
        if section.cell_type not in SOLID_ELEMENTS:
            continue
        values = solid_rotation(SOLID_ELEMENTS[section.cell_type], section.corners(model.mesh))
        dofs = nodal_freedoms(section.nodes(model.mesh), d, 3)
        rows = n_rows + np.arange(values.shape[0] * 3).reshape(-1, 3)
        rotation.append(values.ravel())
        row.append(np.broadcast_to(rows[:, :, None], values.shape).ravel())
        column.append(np.broadcast_to(dofs[:, None], values.shape).ravel())
        n_rows += rows.size
    entries = (np.concatenate(rotation), (np.concatenate(row), np.concatenate(column)))
    return coo_array(entries, shape=(n_rows, model.n_dofs)).tocsc()
