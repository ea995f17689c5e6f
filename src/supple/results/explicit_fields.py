"""Stress and plastic strain at the nodes of explicit elements."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.integrate import Motion
from supple.methods.explicit import ExplicitShell, ExplicitSubdomain
from supple.methods.explicit.motions import NodalMotion

__all__ = ["PartStress", "element_means", "largest_part_stress"]

FloatArray = NDArray[np.float64]


def element_means(
    body: ExplicitSubdomain | ExplicitShell, values: FloatArray, alive: FloatArray
) -> FloatArray:
    """Nodal means (t, N) of values (t, E) over the elements that are not deleted; zero if all are deleted."""
    at_node = sparse.vstack(
        [
            sparse.csr_array(
                (
                    np.ones(nodes.size),
                    (np.repeat(np.arange(len(nodes)), nodes.shape[1]), nodes.ravel()),
                ),
                shape=(len(nodes), len(body.nodes)),
            )
            for nodes in (body.mesh.cells[own.cell_type][own.cells] for own in body.model.sections)
        ],
        format="csr",
    )
    return ((values * alive) @ at_node) / np.maximum(alive @ at_node, 1.0)


class PartStress(NamedTuple):
    """Largest von Mises stress, Pa, and its time.

    place : id of the cell;   point : (3,) centre of the undeformed cell, in the mesh axes
    """

    value: float
    time: float
    place: int
    point: FloatArray


def largest_part_stress(
    body: ExplicitSubdomain | ExplicitShell, times: FloatArray, motion: Motion
) -> PartStress:
    """The largest stress over all cells and output times (t,)."""
    mesh, sections, stress = body.mesh, body.model.sections, motion.of_type(NodalMotion).von_mises
    row, cell = np.unravel_index(stress.argmax(), stress.shape)
    ids = np.concatenate([mesh.cell_ids[own.cell_type][own.cells] for own in sections])
    points = np.concatenate([own.corners(mesh).mean(axis=1) for own in sections])
    return PartStress(float(stress[row, cell]), float(times[row]), int(ids[cell]), points[cell])
