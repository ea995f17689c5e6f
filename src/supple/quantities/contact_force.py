"""Contacts of an explicit run: their forces and points of action, and the motion of rigid obstacles."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from supple.arrays import FloatArray
from supple.integrate import Solution
from supple.machine import System
from supple.methods.explicit import CONTACTS, OBSTACLES
from supple.quantities.reading import Channel, QuantityKind, vector_channels

__all__ = ["ContactForce", "ContactForceSensor", "ObstacleSensor", "contact_forces", "contact_names"]


class ContactForce(NamedTuple):
    """Force (t, 3) on the nodes of a contact, unit of force, and its point of action (t, 3), global axes."""

    name: str
    force: FloatArray
    place: FloatArray


def contact_names(system: System) -> list[str]:
    """Names of all contacts, those with rigid obstacles first: `contact of BODY.NODE_SET`.

    A number distinguishes further contacts of the same nodes.
    """
    seen: Counter[str] = Counter()
    names = []
    for contact in (*system.rigid_contacts, *system.surface_contacts):
        name = f"contact of {contact.nodes}"
        seen[name] += 1
        names.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return names


def contact_forces(system: System, solution: Solution) -> list[ContactForce]:
    """Forces of all contacts, in the order of `contact_names`; empty for a run without contact forces."""
    if CONTACTS not in solution.series:
        return []
    names = contact_names(system)
    recorded = np.split(solution.series[CONTACTS], len(names), axis=1)
    return [ContactForce(name, own[:, :3], own[:, 3:]) for name, own in zip(names, recorded, strict=True)]


@dataclass(frozen=True)
class ContactForceSensor:
    """Force of a contact of an explicit run on its nodes, (t, 3), global axes.

    contact : one of `contact_names`
    """

    name: str
    contact: str

    def channels(self, _system: System) -> Sequence[Channel]:
        """Fx, Fy, Fz."""
        return vector_channels("global", {"F": QuantityKind.FORCE})

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, 3)."""
        return {each.name: each.force for each in contact_forces(system, solution)}[self.contact]


@dataclass(frozen=True)
class ObstacleSensor:
    """Displacement since the start, and velocity, of the obstacle of a contact, (t, 6), global axes.

    contact : one of `contact_names`, of a contact with a rigid obstacle
    """

    name: str
    contact: str

    def channels(self, _system: System) -> Sequence[Channel]:
        """x, y, z, vx, vy, vz."""
        return vector_channels("global", {"": QuantityKind.LENGTH, "v": QuantityKind.VELOCITY})

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, 6)."""
        number = contact_names(system).index(self.contact)
        return solution.series[OBSTACLES][:, 6 * number : 6 * number + 6]
