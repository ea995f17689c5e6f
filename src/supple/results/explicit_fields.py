"""Stress and plastic strain at the nodes of the parts of an explicit run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.integrate import FloatingMotion
from supple.methods.explicit import (
    ExplicitShell,
    ExplicitSubdomain,
    ModalSubdomain,
    NodalMotion,
)
from supple.methods.explicit.elements import SolidPoints
from supple.methods.explicit.explicit_shell import ShellElements
from supple.methods.explicit.modal_stress import modal_von_mises, stress_of_modes

__all__ = ["PartStress", "element_means", "largest_part_stress", "nodal_von_mises"]

FloatArray = NDArray[np.float64]


def element_means(
    subdomain: ExplicitSubdomain | ExplicitShell, values: FloatArray, alive: FloatArray
) -> FloatArray:
    """Mean (t, N) at each node of values (t, E) over the elements there that are left; zero without any."""
    at_node = sparse.vstack(
        [
            sparse.csr_array(
                (
                    np.ones(points.nodes.size),
                    (np.repeat(np.arange(len(points.nodes)), points.nodes.shape[1]), points.nodes.ravel()),
                ),
                shape=(len(points.nodes), len(subdomain.nodes)),
            )
            for points in _elements(subdomain)
        ],
        format="csr",
    )
    return ((values * alive) @ at_node) / np.maximum(alive @ at_node, 1.0)


def _elements(subdomain: ExplicitSubdomain | ExplicitShell) -> Sequence[SolidPoints | ShellElements]:
    return subdomain.elements if isinstance(subdomain, ExplicitShell) else subdomain.points


class PartStress(NamedTuple):
    """Von Mises', Pa, when, and where: the id of a node of a modal part, or of a cell of an explicit one.

    point : (3,) undeformed, in the mesh axes
    """

    value: float
    time: float
    place: int
    point: FloatArray


def largest_part_stress(
    body: ModalSubdomain | ExplicitSubdomain | ExplicitShell, times: FloatArray, motion: Any
) -> PartStress:
    """Of all output times (t,)."""
    mesh = body.mesh
    if not isinstance(body, ModalSubdomain):
        row, cell = np.unravel_index(motion.von_mises.argmax(), motion.von_mises.shape)
        sections = body.model.sections
        ids = np.concatenate([mesh.cell_ids[own.cell_type][own.cells] for own in sections])
        points = np.concatenate([own.corners(mesh).mean(axis=1) for own in sections])
        return PartStress(float(motion.von_mises[row, cell]), float(times[row]), int(ids[cell]), points[cell])
    of_modes, found = stress_of_modes(body), []
    for time, coordinates in zip(times, motion.coordinates, strict=True):
        (stress,) = modal_von_mises(of_modes, coordinates[None])
        node = int(stress.argmax())
        found.append(PartStress(float(stress[node]), float(time), int(mesh.node_ids[node]), mesh.nodes[node]))
    return max(found, key=lambda each: each.value)


def nodal_von_mises(
    subdomain: ModalSubdomain | ExplicitSubdomain | ExplicitShell, motion: FloatingMotion | NodalMotion
) -> FloatArray:
    """Von Mises stress (t, N) of a part, Pa."""
    if isinstance(subdomain, ModalSubdomain):
        assert isinstance(motion, FloatingMotion)
        return modal_von_mises(stress_of_modes(subdomain), motion.coordinates)
    assert isinstance(motion, NodalMotion)
    return element_means(subdomain, motion.von_mises, motion.alive)
