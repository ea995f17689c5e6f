"""The force of each contact of an explicit march over time, and where it acts."""

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
    """Force (t, 3), N, on the nodes that a contact names, and the place (t, 3) where it acts, global axes."""

    name: str
    force: Array
    place: Array


def contact_forces(system: System, solution: Solution) -> list[ContactForce]:
    """Of all contacts, those with rigid obstacles first; none of a result that did not record them."""
    if CONTACTS not in solution.series:
        return []
    contacts = (*system.rigid_contacts, *system.surface_contacts)
    recorded = np.split(solution.series[CONTACTS], len(contacts), axis=1)
    return [
        ContactForce(f"contact of {contact.nodes}", own[:, :3], own[:, 3:])
        for contact, own in zip(contacts, recorded, strict=True)
    ]
