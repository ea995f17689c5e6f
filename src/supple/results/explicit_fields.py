"""Stress and plastic strain at the nodes of explicit elements."""

from __future__ import annotations

from typing import Any, TypeGuard

import numpy as np
from scipy import sparse

from supple.arrays import FloatArray
from supple.body import BodyForm
from supple.integrate import Solution
from supple.methods.explicit import ExplicitShell, ExplicitSubdomain
from supple.methods.explicit.motions import NodalMotion
from supple.units import UnitSystem


def has_explicit_elements(body: BodyForm) -> TypeGuard[ExplicitSubdomain | ExplicitShell]:
    """Whether the body consists of explicit elements, which have no frame."""
    return not body.has_frame


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


def largest_part_stress(
    body: ExplicitSubdomain | ExplicitShell, solution: Solution, units: UnitSystem
) -> dict[str, Any]:
    """The largest von Mises stress over all cells and output times, with its cell, place and time."""
    mesh, sections = body.mesh, body.model.sections
    stress = solution.motion(body.name, NodalMotion).von_mises
    row, cell = np.unravel_index(stress.argmax(), stress.shape)
    ids = np.concatenate([mesh.cell_ids[own.cell_type][own.cells] for own in sections])
    points = np.concatenate([own.corners(mesh).mean(axis=1) for own in sections])
    return {
        "largest von Mises stress": float(stress[row, cell]),
        "unit": units.stress,
        "cell": int(ids[cell]),
        "point": points[cell].tolist(),
        "time": float(solution.times[row]),
    }
