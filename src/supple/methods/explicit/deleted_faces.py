"""Check for deleted elements below the faces of contacts and pressures; faces remain those at the start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from supple.equations.checks.strictness import Watch
from supple.integrate import Solution, Validity
from supple.machine import FollowerPressure, System
from supple.mesh.outer_faces import outer_triangles
from supple.methods.explicit.explicit_shell import ExplicitShell
from supple.methods.explicit.explicit_subdomain import ExplicitSubdomain
from supple.methods.explicit.motions import NodalMotion


@dataclass(frozen=True, eq=False)
class DeletionWatch(Watch[float]):
    """Parts whose elements can be deleted below faces of a contact or a pressure.

    below : message, name of the part, and its elements (E,) below the faces
    """

    below: tuple[tuple[str, str, NDArray[np.bool_]], ...]

    def updated(self, so_far: Mapping[str, float], leg: Solution) -> dict[str, float]:
        """Messages with the time of the first deletion."""
        found = dict(so_far)
        for message, part, below in self.below:
            alive = leg.motion(part, NodalMotion).alive[:, below].all(axis=1)
            if not alive.all():
                found.setdefault(message, float(leg.times[alive.argmin()]))
        return found

    def excesses(self, found: Mapping[str, float]) -> list[str]:
        """A message for every contact and pressure with deleted elements."""
        return [f"{message} (t = {time:.4g})" for message, time in found.items()]


def deletion_watch(system: System, validity: Validity) -> DeletionWatch:
    """Prepare the contacts and pressures of a system on faces of elements that can be deleted."""
    below = []
    for contact in system.surface_contacts:
        part = system.placed(contact.surface.body).body
        if _can_lose_elements(part):
            faces = outer_triangles(part.mesh, system.node_numbers(contact.surface))
            message = (
                f"contact of '{contact.nodes}' with '{contact.surface}': elements below its faces are "
                "deleted. The contact has no faces on the elements behind them, so nodes pass through these "
                "elements, and later results there are wrong: leave the deletion strain out, or raise it"
            )
            below.append((message, part.name, _below(part, faces)))
    for load in system.loads:
        if isinstance(load, FollowerPressure):
            part = system.placed(load.body).body
            if _can_lose_elements(part):
                message = (
                    f"{load.label}: elements below its faces are deleted. The pressure still acts on the "
                    "nodes of these faces, so later results are wrong: leave the deletion strain out, raise "
                    "it, or end the pressure earlier (its law)"
                )
                below.append((message, part.name, _below(part, np.asarray(load.faces))))
    return DeletionWatch(validity, tuple(below))


def _can_lose_elements(part: object) -> TypeGuard[ExplicitSubdomain | ExplicitShell]:
    return isinstance(part, ExplicitSubdomain | ExplicitShell) and bool(np.isfinite(part.deletion))


def _below(part: ExplicitSubdomain | ExplicitShell, faces: NDArray[np.int64]) -> NDArray[np.bool_]:
    """The elements (E,) below some faces: three nodes of an element on them are the corners of a face."""
    on = [
        np.isin(part.mesh.cells[own.cell_type][own.cells], faces).sum(axis=1) >= 3
        for own in part.model.sections
    ]
    return np.concatenate(on)
