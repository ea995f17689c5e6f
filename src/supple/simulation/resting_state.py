"""The search for an equilibrium, from a machine to the arrays of its state at rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from supple.equations.configuration import Configuration
from supple.equations.control_force import states_by_controller
from supple.equations.static_search import (
    Equations,
    StaticSearch,
    StaticState,
    search_equilibrium,
)
from supple.equations.steady_motion import SteadyTurning
from supple.errors import ModelError
from supple.machine import Controller, Placed, SampledController, Spin, System
from supple.simulation.equations_of import equations_of

__all__ = ["RestingState", "at_rest", "check_time", "placed_at_rest", "resting_state"]


class RestingState(NamedTuple):
    """An equilibrium as arrays."""

    system: System
    """As it was placed"""
    turning: SteadyTurning
    state: StaticState
    iterations: int
    equations: Equations

    @property
    def configuration(self) -> Configuration:
        """Where the bodies are, in their order."""
        return self.equations.bodies_at(self.state.configuration)


def resting_state(
    system: System,
    *,
    time: float,
    spin: Spin | None,
    search: StaticSearch | None = None,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> RestingState:
    """The arrays behind an `equilibrium`, with its arguments and errors."""
    check_time(time)
    _refuse_sampled(system)
    search = StaticSearch() if search is None else search
    turning = SteadyTurning(np.zeros((len(system.bodies), 3)), np.zeros(3))
    if spin is not None:
        turning = SteadyTurning(spin.angular_velocities(system), spin.point)
    still = replace(system, bodies=tuple(at_rest(placed) for placed in system.bodies))
    equations = equations_of(still, turning if spin else None, time)
    state, iterations = search_equilibrium(equations, equations.start(), time, search, progress)
    return RestingState(still, turning, state, iterations, equations)


def check_time(time: float) -> None:
    """Raise ModelError for the time of an equilibrium that is no number."""
    if not np.isfinite(time):
        raise ModelError(f"the time of an equilibrium must be finite, got {time}")


def _refuse_sampled(system: System) -> None:
    for controller in system.controllers:
        if isinstance(controller, SampledController):
            raise ModelError(
                f"controller '{controller.name}' is sampled: plain Python that is called between steps has "
                "neither a rest nor eigenvalues. Write its law as a Controller, in jax.numpy, with what it "
                "remembers as states, or leave it out, replace(system, controllers=()). A damped run finds "
                "a rest with it, but no modes"
            )


def at_rest(placed: Placed) -> Placed:
    """Without any velocity."""
    return replace(placed, velocity=None, angular_velocity=None, coordinate_rates=np.zeros(0))


def placed_at_rest(found: RestingState) -> System:
    """The system with its bodies as in the state, turning steadily."""
    bodies, first = [], 0
    system, (velocities, point), configuration = found.system, found.turning, found.configuration
    for index, placed in enumerate(system.bodies):
        after = first + placed.body.n_coordinates
        rotation = np.asarray(configuration.rotations[index])
        moved = placed.moved_to(np.asarray(configuration.origins[index]), rotation)
        resting = replace(moved, coordinates=configuration.coordinates[first:after])
        if velocities.any():
            resting = replace(
                resting,
                velocity=np.cross(velocities[index], moved.position - point),
                angular_velocity=velocities[index] @ moved.rotation,
            )
        bodies.append(resting)
        first = after
    return replace(system, bodies=tuple(bodies), controllers=_resting(system, found))


def _resting(system: System, found: RestingState) -> tuple[Controller | SampledController, ...]:
    """The controllers, beginning with the states at rest."""
    states = states_by_controller(found.equations.model, found.state.control)
    return tuple(
        replace(own, initial=state) if isinstance(own, Controller) else own
        for own, state in zip(system.controllers, states, strict=True)
    )
