"""Runs of bodies with inert coordinates, which no one outside sees."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from supple.integrate import FloatingMotion, Leg, Run, Solution
from supple.machine import Placed, System
from supple.multibody.compiled.engine import CompiledEngine
from supple.multibody.compiled.state import State
from supple.reduction import ReducedBody, filled_up

__all__ = ["RoomyEngine", "has_room", "in_own_coordinates", "with_inert_coordinates"]

_OF_COORDINATES = ("coordinates", "coordinate_rates", "coordinate_accelerations")


class RoomyEngine:
    """A `CompiledEngine` of bodies that are filled up with inert coordinates; it marches as that one does."""

    def __init__(self, system: System, run: Run) -> None:
        self._system = system
        self._engine = CompiledEngine(with_inert_coordinates(system), run)

    def start(self, time: float) -> State:
        """The initial state, in all coordinates."""
        return self._engine.start(time)

    def march(self, state: State, times: np.ndarray) -> Leg[State]:
        """As that engine does."""
        return self._engine.march(state, times)

    def resumed(self, last: Solution) -> State:
        """The state at the end of a recorded part."""
        return self._engine.resumed(_resized(self._system, last, lambda own, body: _filled(own, body.inert)))

    def solution(self, leg: Leg[State]) -> Solution:
        """The motion of a leg, in the bodies' own coordinates; its `engine_state` is that of all of them.

        A `CompiledEngine` of the bodies alone goes on from it as from one without.
        """
        return in_own_coordinates(self._system, self._engine.solution(leg))


def has_room(system: System) -> bool:
    """Whether bodies are to be run with inert coordinates."""
    return any(body.inert for body in system.bodies_of(ReducedBody).values())


def with_inert_coordinates(system: System) -> System:
    """The system with its bodies filled up."""

    def filled(placed: Placed) -> Placed:
        body = placed.body
        if not isinstance(body, ReducedBody) or not body.inert:
            return placed
        return replace(
            placed,
            body=filled_up(body),
            coordinates=_filled(placed.coordinates, body.inert),
            coordinate_rates=_filled(placed.coordinate_rates, body.inert),
        )

    return replace(system, bodies=tuple(filled(placed) for placed in system.bodies))


def in_own_coordinates(system: System, solution: Solution) -> Solution:
    """The motion without inert coordinates."""
    return _resized(system, solution, lambda own, body: own[..., : body.r])


def _filled(own: np.ndarray, more: int) -> np.ndarray:
    return np.pad(own, [(0, 0)] * (own.ndim - 1) + [(0, more)])


def _resized(
    system: System, solution: Solution, to_size: Callable[[np.ndarray, ReducedBody], np.ndarray]
) -> Solution:
    """A solution whose coordinates have another number."""
    bodies: Mapping[str, ReducedBody] = system.bodies_of(ReducedBody)
    moved = {}
    for name, motion in solution.bodies.items():
        if name not in bodies or not bodies[name].inert:
            moved[name] = motion
            continue
        assert isinstance(motion, FloatingMotion)
        sized = {item: to_size(getattr(motion, item), bodies[name]) for item in _OF_COORDINATES}
        moved[name] = replace(motion, **sized)
    return replace(solution, bodies=moved)
