"""Rotations of a model: how far its material turns, linearly, from the nodal freedoms."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csc_array

from supple.fem.model import SOLID_ELEMENTS, FiniteElementModel, nodal_freedoms
from supple.fem.solid_element import solid_rotation

__all__ = ["nodal_rotation_operator"]


def nodal_rotation_operator(model: FiniteElementModel) -> csc_array:
    """Operator (3 P, n) that gives the rotation vector at P points from the nodal freedoms.

    Shells: the rotational freedoms of all nodes, P = N. Solids: half the curl of u at the centre of each
    cell.
    """
    if model.dofs_per_node == 6:
        columns = (6 * np.arange(model.mesh.n_nodes)[:, None] + np.arange(3, 6)).ravel()
        entries = (np.ones(len(columns)), (np.arange(len(columns)), columns))
        return coo_array(entries, shape=(len(columns), model.n_dofs)).tocsc()
    rotation, row, column = [], [], []
    n_rows = 0
    for section in model.sections:
        values = solid_rotation(SOLID_ELEMENTS[section.cell_type], section.corners(model.mesh))
        dofs = nodal_freedoms(section.nodes(model.mesh), 3)
        rows = n_rows + np.arange(values.shape[0] * 3).reshape(-1, 3)
        rotation.append(values.ravel())
        row.append(np.broadcast_to(rows[:, :, None], values.shape).ravel())
        column.append(np.broadcast_to(dofs[:, None], values.shape).ravel())
        n_rows += rows.size
    entries = (np.concatenate(rotation), (np.concatenate(row), np.concatenate(column)))
    return coo_array(entries, shape=(n_rows, model.n_dofs)).tocsc()
