"""Errors due to the bases of reduced bodies at places of a machine at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from supple.arguments import checked_arguments
from supple.machine import At
from supple.quantities import Place, tracked_places
from supple.simulation.equilibrium import Equilibrium

__all__ = ["PlaceError", "place_errors"]


@dataclass(frozen=True, eq=False)
class PlaceError:
    """Basis errors at one place at rest: value on the reduced body minus value with all coordinates.

    position : (3,) | None      in global axes; None if the joints leave rigid motion free
    deflection : (3,) | None    relative to the body's first interface or a given one, in the axes of the
        interface; None for a rigid body
    """

    position: np.ndarray | None
    deflection: np.ndarray | None


@checked_arguments
def place_errors(
    found: Equilibrium, places: Mapping[str, Place], bases: Mapping[str, At] = MappingProxyType({})
) -> dict[str, PlaceError]:
    """Errors of the positions and deflections at places of a machine in equilibrium, by name of the place.

        error = place on the reduced bodies - place with all coordinates

    places, bases : as in `tracked_places`
    Places with unknown error are omitted; without an equilibrium with all coordinates, these are all places.
    """
    if found.full is None:
        return {}
    known = {}
    for name, place in places.items():
        own, full = (system.placed(place.body).body for system in (found.system, found.full[0]))
        if full is own or full.kind == "full":  # forms with the same places
            known[name] = place
    exact = tracked_places(*found.full, known, bases)
    errors = {}
    for name, own in tracked_places(found.system, found.solution, known, bases).items():
        position = own.position[0] - exact[name].position[0] if found.is_held else None
        deflection = own.deflection[0] - exact[name].deflection[0] if own.is_elastic else None
        errors[name] = PlaceError(position, deflection)
    return errors
