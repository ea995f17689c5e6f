"""Stress and plastic strain at the nodes of explicit elements."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.methods.explicit import ExplicitShell, ExplicitSubdomain

__all__ = ["PartStress", "element_means", "largest_part_stress"]

FloatArray = NDArray[np.float64]


def element_means(
    body: ExplicitSubdomain | ExplicitShell, values: FloatArray, alive: FloatArray
) -> FloatArray:
    """Mean (t, N) at each node of values (t, E) over the elements there that are left; zero without any."""
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
    """Von Mises', Pa, when, and where: the id of a cell.

    point : (3,) undeformed, in the mesh axes
    """

    value: float
    time: float
    place: int
    point: FloatArray


def largest_part_stress(
    body: ExplicitSubdomain | ExplicitShell, times: FloatArray, motion: Any
) -> PartStress:
    """Of all output times (t,)."""
    mesh, sections = body.mesh, body.model.sections
    row, cell = np.unravel_index(motion.von_mises.argmax(), motion.von_mises.shape)
    ids = np.concatenate([mesh.cell_ids[own.cell_type][own.cells] for own in sections])
    points = np.concatenate([own.corners(mesh).mean(axis=1) for own in sections])
    return PartStress(float(motion.von_mises[row, cell]), float(times[row]), int(ids[cell]), points[cell])
