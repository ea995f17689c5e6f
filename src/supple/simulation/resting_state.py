"""The search for an equilibrium, from a machine to the arrays of its state at rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from supple.body import FullBody
from supple.equations.build_model import build_model
from supple.equations.configuration import Configuration
from supple.equations.consistent_start import consistent_start
from supple.equations.control_force import first_states, states_by_controller
from supple.equations.model import Model
from supple.equations.static_search import (
    StaticMachine,
    StaticSearch,
    StaticState,
    search_equilibrium,
)
from supple.equations.steady_motion import Turning
from supple.errors import ModelError
from supple.machine import Placed, Spin, System
from supple.machine.control import Controller, SampledController
from supple.methods.floating import CompiledStatics, FullStatics
from supple.methods.floating.compiled.compiled_machine import CompiledMachine
from supple.methods.intrinsic import IntrinsicBody
from supple.methods.intrinsic.line_statics import line_statics
from supple.simulation.seen_machine import full_system

__all__ = ["RestingState", "at_rest", "check_time", "placed_at_rest", "resting_state"]


class RestingState(NamedTuple):
    """An equilibrium as arrays."""

    system: System
    """As it was placed"""
    model: Model
    slices: tuple[slice, ...]
    """Of each body's freedoms"""
    turning: Turning
    state: StaticState
    iterations: int
    machine: StaticMachine
    """In the hands of its engine"""

    @property
    def configuration(self) -> Configuration:
        """Where the bodies are, in their order."""
        return self.machine.bodies_at(self.state.configuration)


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
    turning = Turning(np.zeros((len(system.bodies), 3)), np.zeros(3))
    if spin is not None:
        turning = Turning(spin.angular_velocities(system), spin.point)
    still = replace(system, bodies=tuple(at_rest(placed) for placed in system.bodies))
    lines, full = system.bodies_of(IntrinsicBody), system.bodies_of(FullBody)
    if lines and not (full or system.controllers):
        lines = line_statics(still, turning if spin else None, time)
        state, iterations = search_equilibrium(lines, lines.start, time, search, progress)
        return RestingState(still, lines.machine.arrays.model, (), turning, state, iterations, lines)
    if full or lines:
        machine, configuration, *_ = consistent_start(full_system(still), time)
        statics, model = FullStatics(machine, turning if spin else None), machine.model
        slices = machine.slices
        frames = tuple(np.zeros(6) for _ in machine.interiors)
    else:
        compiled, configuration, *_ = consistent_start(CompiledMachine(still, build_model(still)), time)
        statics, model, frames = CompiledStatics(compiled, turning if spin else None), compiled.model, ()
        slices = compiled.slices
    start = StaticState(configuration, np.zeros(len(model.active)), frames, first_states(model))
    state, iterations = search_equilibrium(statics, start, time, search, progress)
    return RestingState(still, model, slices, turning, state, iterations, statics)


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
    """The system with its bodies where the state says, turning steadily."""
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
    states = states_by_controller(found.model, found.state.control)
    return tuple(
        replace(own, initial=state) if isinstance(own, Controller) else own
        for own, state in zip(system.controllers, states, strict=True)
    )
