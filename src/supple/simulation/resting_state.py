"""The search for an equilibrium, and the state found as arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from supple.equations.build_model import system_length
from supple.equations.configuration import Configuration
from supple.equations.control_force import states_by_controller
from supple.equations.static_search import Equations, StaticSearch, StaticState, search_equilibrium
from supple.equations.steady_motion import SteadyRotation
from supple.equations.stops import laws_of
from supple.errors import ConvergenceError, ModelError
from supple.integrate import Solution
from supple.machine import GROUND, Controller, Placed, SampledController, Spin, System
from supple.machine.laws.time_law import check_law_covers
from supple.simulation.equations_of import equations_of
from supple.simulation.spin_of_joints import check_joints_permit
from supple.summary import place_text

_ON_AXIS = 1e-6
"""Distance of a centre of mass from the axis, relative to the size of the machine, that is rounding."""


class RestingState(NamedTuple):
    """An equilibrium as arrays."""

    system: System
    """The machine as placed, without velocities."""
    turning: SteadyRotation
    state: StaticState
    iterations: int
    equations: Equations

    @property
    def configuration(self) -> Configuration:
        """Poses of the bodies, in their order."""
        return self.equations.bodies_at(self.state.configuration)

    def solution(self, time: float) -> Solution:
        """The equilibrium as a motion with one output time."""
        return self.equations.solution(self.state, time, self.iterations)


def resting_state(
    system: System,
    *,
    time: float,
    spin: Spin | None,
    search: StaticSearch | None = None,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> RestingState:
    """The equilibrium of a machine as arrays; arguments and errors as for `equilibrium`."""
    if not np.isfinite(time):
        raise ModelError(f"the time of an equilibrium must be finite, got {time}")
    for what, law in laws_of(system):
        check_law_covers(what, law, time)
    _refuse_sampled(system)
    search = StaticSearch() if search is None else search
    turning = SteadyRotation(np.zeros((len(system.bodies), 3)), np.zeros(3))
    if spin is not None:
        turning = SteadyRotation(spin.angular_velocities(system), spin.point)
        check_joints_permit(system, turning, time)
    still = replace(system, bodies=tuple(at_rest(placed) for placed in system.bodies))
    equations = equations_of(still, turning if spin else None, time)
    try:
        state, iterations = search_equilibrium(equations, equations.start(), time, search, progress)
    except ConvergenceError as error:
        if cause := _off_axis(still, turning):
            raise ConvergenceError(f"{error}. {cause}") from error
        raise
    return RestingState(still, turning, state, iterations, equations)


def _off_axis(system: System, turning: SteadyRotation) -> str:
    """Why a free machine cannot rotate about an axis that misses its centre of mass; else ""."""
    parts: list[Any] = [*system.joints, *system.loads]
    on_ground = any(GROUND in (getattr(part, "first", None), getattr(part, "second", None)) for part in parts)
    rates = np.asarray(turning.angular_velocities)
    spins = np.flatnonzero(np.linalg.norm(rates, axis=1))
    if not len(spins) or on_ground:
        return ""
    bodies = [system.bodies[index] for index in spins]
    masses = [placed.body.mass for placed in bodies]
    places = [placed.position + placed.rotation @ placed.body.centre_of_mass for placed in bodies]
    centre = np.average(places, axis=0, weights=masses)
    axis = rates[spins[0]] / np.linalg.norm(rates[spins[0]])
    away = np.linalg.norm(np.cross(centre - turning.point, axis))
    if away <= _ON_AXIS * system_length(system):
        return ""
    return (
        f"Nothing holds the rotating bodies, and the axis of the spin is {away:.3g} from their centre of "
        f"mass: give the spin the point {place_text(centre)}"
    )


def _refuse_sampled(system: System) -> None:
    for controller in system.controllers:
        if isinstance(controller, SampledController):
            raise ModelError(
                f"controller '{controller.name}' is sampled: a Python function called between steps has "
                "neither an equilibrium nor eigenvalues. Write it as a Controller, in jax.numpy, with its "
                "memory as states, or remove it, replace(system, controllers=()). A damped run finds "
                "an equilibrium with it, but no modes"
            )


def at_rest(placed: Placed) -> Placed:
    """The placed body without velocities and coordinate rates."""
    none = np.zeros(0)
    return replace(placed, velocity=None, angular_velocity=None, coordinate_rates=none, is_moving=False)


def placed_at_rest(found: RestingState) -> System:
    """The system with the poses and deformation of the state, and the velocities of its steady rotation.

    Its controllers begin with their states at equilibrium.
    """
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
    states = states_by_controller(found.equations.model, found.state.control)
    controllers = tuple(
        replace(own, initial=state) if isinstance(own, Controller) else own
        for own, state in zip(system.controllers, states, strict=True)
    )
    return replace(system, bodies=tuple(bodies), controllers=controllers)
