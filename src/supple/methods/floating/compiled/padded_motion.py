"""Systems and motions with the padding coordinates of their bodies, and without."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from supple.integrate import FloatingMotion, Solution
from supple.machine import Placed, System
from supple.reduction import ReducedBody, filled_up, padded_with_zeros

_OF_COORDINATES = ("coordinates", "coordinate_rates", "coordinate_accelerations")
"""Fields of a `FloatingMotion` whose size is the number of coordinates."""


def with_padding_coordinates(system: System) -> System:
    """The system with padded bodies; the system itself where no body has padding coordinates."""

    def filled(placed: Placed) -> Placed:
        body = placed.body
        if not isinstance(body, ReducedBody) or not body.padding:
            return placed
        return replace(
            placed,
            body=filled_up(body),
            coordinates=padded_with_zeros(placed.coordinates, body.padding),
            coordinate_rates=padded_with_zeros(placed.coordinate_rates, body.padding),
        )

    if not _padded_bodies(system):
        return system
    return replace(system, bodies=tuple(filled(placed) for placed in system.bodies))


def in_all_coordinates(system: System, solution: Solution) -> Solution:
    """A motion of the system in the coordinates of its padded bodies."""
    return _resized(system, solution, lambda own, body: padded_with_zeros(own, body.padding))


def in_own_coordinates(system: System, solution: Solution) -> Solution:
    """A motion of the padded bodies in the coordinates of the system."""
    return _resized(system, solution, lambda own, body: own[..., : body.r])


def _padded_bodies(system: System) -> dict[str, ReducedBody]:
    """The bodies with padding coordinates, by name."""
    return {name: body for name, body in system.bodies_of(ReducedBody).items() if body.padding}


def _resized(
    system: System, solution: Solution, to_size: Callable[[np.ndarray, ReducedBody], np.ndarray]
) -> Solution:
    """A solution with another number of coordinates."""
    padded = _padded_bodies(system)
    if not padded:
        return solution
    bodies = dict(solution.bodies)
    for name, body in padded.items():
        motion = solution.motion(name, FloatingMotion)
        sized = {item: to_size(getattr(motion, item), body) for item in _OF_COORDINATES}
        bodies[name] = replace(motion, **sized)
    return replace(solution, bodies=bodies)
