"""Force of each contact of an explicit run over time, and its point of action."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from supple.integrate import Solution
from supple.machine import System
from supple.methods.explicit import CONTACTS

__all__ = ["ContactForce", "contact_forces"]

Array = NDArray[np.float64]


class ContactForce(NamedTuple):
    """Force (t, 3) on the nodes of a contact, unit of force, and its point of action (t, 3), global axes."""

    name: str
    force: Array
    place: Array


def contact_forces(system: System, solution: Solution) -> list[ContactForce]:
    """Forces of all contacts, those with rigid obstacles first; empty for a run without contact forces."""
    if CONTACTS not in solution.series:
        return []
    contacts = (*system.rigid_contacts, *system.surface_contacts)
    recorded = np.split(solution.series[CONTACTS], len(contacts), axis=1)
    return [
        ContactForce(f"contact of {contact.nodes}", own[:, :3], own[:, 3:])
        for contact, own in zip(contacts, recorded, strict=True)
    ]
