"""Equilibrium of a machine: where it rests, or how it turns steadily, under its loads at one time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from supple.arguments import checked_arguments
from supple.body import FullBody
from supple.errors import ModelError
from supple.integrate import Solution, Statistics
from supple.intrinsic import IntrinsicBody
from supple.intrinsic.line_rest import resting_lines
from supple.intrinsic.supported_root import is_joined
from supple.machine import Placed, Spin, System
from supple.machine.control import Controller, SampledController
from supple.multibody import CompiledStatics, FullStatics
from supple.multibody.compiled.compiled_machine import CompiledMachine
from supple.multibody.equations.build_model import build_model
from supple.multibody.equations.configuration import Configuration, SystemMotion
from supple.multibody.equations.consistent_start import consistent_start, placed_velocity
from supple.multibody.equations.control_force import first_states, states_by_controller
from supple.multibody.equations.floating_solution import floating_solution
from supple.multibody.equations.model import Model
from supple.multibody.equations.static_search import StaticSearch, StaticState, search_equilibrium
from supple.multibody.equations.steady_motion import Turning
from supple.multibody.full.full_system import FullSystem

__all__ = ["Equilibrium", "RestingState", "equilibrium", "placed_at_rest", "resting_state"]


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A machine at rest, or turning steadily.

    system     : System     its bodies placed, moving and deformed as they are: `simulate` starts there
    solution   : Solution   the same as a motion of one instant, for what reads motions
    iterations : int        that the search took
    """

    system: System
    solution: Solution
    iterations: int

    @property
    def joint_forces(self) -> Mapping[str, np.ndarray]:
        """Force and moment (6,) on each joint's second end, as in a `Solution`."""
        return {name: forces[0] for name, forces in self.solution.joint_forces.items()}


@checked_arguments
def equilibrium(
    system: System,
    *,
    time: float = 0.0,
    spin: Spin | None = None,
    search: StaticSearch | None = None,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> Equilibrium:
    """Where a machine rests, or turns steadily, under gravity, its loads and its joints' laws at one time.

        I(q, w) + f(q) + G(q)^T lambda = Q(t, q),     g(q, t) = 0

    with the inertia force `I` of the `spin`, zero without one. The search goes downhill from where the bodies
    are placed, so that it ends in a stable equilibrium nearby. Velocities that the bodies were given do not
    matter; those of the equilibrium are the spin's. Loads and gravity that do not turn along are taken as
    they are at that instant.

    Parameters
    ----------
    time : of the loads and laws
    spin : Spin       of the machine, or of the bodies that it names; the others stand
    search : StaticSearch       accuracy and step
    progress : hears of each iteration and its largest relative residual

    Controllers act as in a run, and their states rest with the machine: `f(0, q, z) = 0`, from which those of
    the equilibrium's system begin.

    Raises
    ------
    ModelError          whatever the start of a run would find wrong with the joints; a controller that is
        sampled; intrinsic bodies that turn, or that hold other bodies or each other
    ConvergenceError    no equilibrium was found, or a controller's state has none
    Source: Kelley & Keyes (1998) for the search; intrinsic bodies by `line_rest`.
    """
    if system.bodies_of(IntrinsicBody) and not is_joined(system) and spin is None:
        return _equilibrium_of_lines(system, time)
    found = resting_state(system, time=time, spin=spin, search=search, progress=progress)
    return Equilibrium(placed_at_rest(found), _one_instant(found, time), found.iterations)


def _equilibrium_of_lines(system: System, time: float) -> Equilibrium:
    """Of intrinsic bodies whose roots the ground holds."""
    _check_time(time)
    still = replace(system, bodies=tuple(_at_rest(placed) for placed in system.bodies))
    found = resting_lines(still, time=time)
    bodies = tuple(
        replace(placed, coordinates=found.bodies[placed.body.name].coordinates[0]) for placed in still.bodies
    )
    return Equilibrium(replace(still, bodies=bodies), found, found.statistics.iterations)


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


def resting_state(
    system: System,
    *,
    time: float,
    spin: Spin | None,
    search: StaticSearch | None = None,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> RestingState:
    """The arrays behind an `equilibrium`, with its arguments and errors."""
    if intrinsic := system.bodies_of(IntrinsicBody):
        raise ModelError(
            f"body '{next(iter(intrinsic))}' is intrinsic: its equilibrium is known where all bodies are, "
            "the ground alone holds their roots, and nothing spins. Leave out the spin, or find where the "
            "machine rests by a run with damping"
        )
    _check_time(time)
    _refuse_sampled(system)
    search = StaticSearch() if search is None else search
    turning = Turning(np.zeros((len(system.bodies), 3)), np.zeros(3))
    if spin is not None:
        turning = Turning(spin.angular_velocities(system), spin.point)
    still = replace(system, bodies=tuple(_at_rest(placed) for placed in system.bodies))
    if system.bodies_of(FullBody):
        machine, configuration, *_ = consistent_start(FullSystem(still), time)
        statics, model = FullStatics(machine, turning if spin else None), machine.model
        slices = machine.slices
        frames = tuple(np.zeros(6) for _ in machine.interiors)
    else:
        compiled, configuration, *_ = consistent_start(CompiledMachine(still, build_model(still)), time)
        statics, model, frames = CompiledStatics(compiled, turning if spin else None), compiled.model, ()
        slices = compiled.slices
    start = StaticState(configuration, np.zeros(len(model.active)), frames, first_states(model))
    state, iterations = search_equilibrium(statics, start, time, search, progress)
    return RestingState(still, model, slices, turning, state, iterations)


def _check_time(time: float) -> None:
    if not np.isfinite(time):
        raise ModelError(f"the time of an equilibrium must be finite, got {time}")


def _refuse_sampled(system: System) -> None:
    for controller in system.controllers:
        if isinstance(controller, SampledController):
            raise ModelError(
                f"controller '{controller.name}' is sampled: plain Python that is called between steps has "
                "neither a rest nor eigenvalues. Write its law as a Controller, in jax.numpy, with what it "
                "remembers as states; leave it out, replace(system, controllers=()); or let a damped run "
                "find its rest"
            )


def _one_instant(found: RestingState, time: float) -> Solution:
    """The equilibrium as a motion of one instant."""
    system, state = placed_at_rest(found), found.state
    configuration = Configuration(*(np.asarray(part)[None] for part in state.configuration))
    moving = placed_velocity(system)[None]
    motion = SystemMotion(
        np.array([time]), configuration, moving, np.zeros_like(moving), np.asarray(state.multipliers)[None]
    )
    statistics = Statistics(steps=0, iterations=found.iterations, rejected_steps=0, seconds=0.0)
    return floating_solution(system, found.slices, found.model.active, motion, statistics)


def _at_rest(placed: Placed) -> Placed:
    return replace(placed, velocity=None, angular_velocity=None, coordinate_rates=np.zeros(0))


def placed_at_rest(found: RestingState) -> System:
    """The system with its bodies where the state says, turning steadily."""
    bodies, first = [], 0
    system, (velocities, point), state = found.system, found.turning, found.state
    for index, placed in enumerate(system.bodies):
        after = first + placed.body.n_coordinates
        rotation = np.asarray(state.configuration.rotations[index])
        moved = placed.moved_to(np.asarray(state.configuration.origins[index]), rotation)
        resting = replace(moved, coordinates=state.configuration.coordinates[first:after])
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
