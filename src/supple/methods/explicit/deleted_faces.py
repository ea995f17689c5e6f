"""Check for deleted elements below the faces of a contact; the faces remain those at the start."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.errors import ValidityError, ValidityWarning
from supple.integrate import Solution, Validity
from supple.machine import SurfaceContact, System
from supple.mesh.outer_faces import outer_triangles
from supple.methods.explicit.explicit_shell import ExplicitShell
from supple.methods.explicit.explicit_subdomain import ExplicitSubdomain
from supple.methods.explicit.motions import NodalMotion

__all__ = ["DeletionWatch", "deletion_watch"]


@dataclass(frozen=True, eq=False)
class DeletionWatch:
    """Contacts with faces of parts whose elements can be deleted, and the elements (E,) below these faces."""

    validity: Validity
    below: tuple[tuple[SurfaceContact, NDArray[np.bool_]], ...]

    def observe(self, so_far: Mapping[str, float], leg: Solution) -> dict[str, float]:
        """Messages with the time of the first deletion; ValidityError at the first one if strict."""
        found = dict(so_far)
        for contact, below in self.below:
            alive = leg.motion(contact.surface.body, NodalMotion).alive[:, below].all(axis=1)
            message = _uncovers(contact)
            if not alive.all():
                found.setdefault(message, float(leg.times[alive.argmin()]))
                if self.validity.strict:
                    raise ValidityError(f"{message} (t = {found[message]:.4g})")
        return found

    def report(self, found: Mapping[str, float]) -> None:
        """Warn about every contact with deleted elements."""
        for message, time in found.items():
            warnings.warn(f"{message} (t = {time:.4g})", ValidityWarning, stacklevel=3)


def deletion_watch(system: System, validity: Validity) -> DeletionWatch:
    """Prepare the contacts of a system that have faces of elements that can be deleted."""
    below = []
    for contact in system.surface_contacts:
        part = system.placed(contact.surface.body).body
        if isinstance(part, ExplicitSubdomain | ExplicitShell) and np.isfinite(part.deletion):
            faces = outer_triangles(part.mesh, system.node_numbers(contact.surface))
            # Three nodes of an element on the surface are the corners of a face.
            on = [
                np.isin(part.mesh.cells[own.cell_type][own.cells], faces).sum(axis=1) >= 3
                for own in part.model.sections
            ]
            below.append((contact, np.concatenate(on)))
    return DeletionWatch(validity, tuple(below))


def _uncovers(contact: SurfaceContact) -> str:
    return (
        f"contact of '{contact.nodes}' with '{contact.surface}': elements below its faces are deleted. The "
        "contact has no faces on the elements behind them, so nodes pass through these elements, and later "
        "results there are wrong: leave the deletion strain out, or raise it"
    )
