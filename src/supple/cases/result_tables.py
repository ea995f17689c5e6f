"""Content of the table of a run: sensors, joint and contact forces, tracked places, energies."""

from __future__ import annotations

import numpy as np

from supple.cases.case import Case
from supple.machine import System
from supple.quantities import (
    ContactForceSensor,
    DeflectionSensor,
    EnergySensor,
    JointForceSensor,
    ObstacleSensor,
    PositionSensor,
    Quantity,
    contact_names,
)
from supple.results.explicit_numbers import MarchEnergySensor
from supple.simulation.engines import is_explicit


def recorded_quantities(case: Case, system: System) -> tuple[Quantity, ...]:
    """All quantities of a table, with unique names.

    The sensors of the case come first. `joint NAME`, `contact of BODY.NODE_SET`, `obstacle of BODY.NODE_SET`,
    `position BODY.PLACE`, `deflection BODY.PLACE` and `energy` follow: obstacles that move, deflections of
    deformable bodies with a frame. A sensor with one of these names replaces that quantity.
    """
    sensors = {sensor.name: sensor for sensor in case.sensors}
    others: list[Quantity] = [JointForceSensor(f"joint {joint.name}", joint.name) for joint in system.joints]
    contacts = contact_names(system)
    others += [ContactForceSensor(name, name) for name in contacts]
    for name, contact in zip(contacts, system.rigid_contacts, strict=False):
        if np.isfinite(contact.obstacle.mass) or any(contact.obstacle.velocity):
            others.append(ObstacleSensor(name.replace("contact", "obstacle", 1), name))
    for words, place in case.track.items():
        body = system.placed(place.body).body
        others.append(PositionSensor(f"position {words}", place))
        if body.n_coordinates and body.has_frame:
            others.append(DeflectionSensor(f"deflection {words}", place, case.bases.get(place.body)))
    marched = is_explicit(system, case.run)
    others.append(MarchEnergySensor("energy") if marched else EnergySensor("energy"))
    return (*sensors.values(), *(each for each in others if each.name not in sensors))
