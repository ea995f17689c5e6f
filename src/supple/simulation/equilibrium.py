"""Static equilibrium of a machine: where it rests under its loads at one time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from supple.body import FullBody
from supple.machine import Placed, System
from supple.multibody import CompiledStatics, FullStatics
from supple.multibody.compiled.compiled_machine import CompiledMachine
from supple.multibody.equations.build_model import build_model
from supple.multibody.equations.configuration import Configuration
from supple.multibody.equations.consistent_start import consistent_start
from supple.multibody.equations.floating_solution import body_motions, joint_multipliers
from supple.multibody.equations.joint_wrench import joint_wrenches
from supple.multibody.equations.static_search import StaticSearch, StaticState, search_equilibrium
from supple.multibody.full.full_system import FullSystem

__all__ = ["Equilibrium", "equilibrium"]


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A machine at rest.

    system       : System       its bodies placed and deformed as they rest: `simulate` starts there
    joint_forces : {name: (6,)} force and moment on each joint's second end, as in a `Solution`
    iterations   : int          that the search took
    """

    system: System
    joint_forces: Mapping[str, np.ndarray]
    iterations: int


def equilibrium(
    system: System,
    *,
    time: float = 0.0,
    search: StaticSearch | None = None,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> Equilibrium:
    """Where a machine rests under gravity, its loads and its joints' laws at one time.

        f(q) + G(q)^T lambda = Q(t, q),     g(q, t) = 0

    The search goes downhill from where the bodies are placed, so that it ends in a stable equilibrium nearby.
    Velocities that the bodies were given do not matter; those of the equilibrium are zero.

    Parameters
    ----------
    time : of the loads and laws
    search : StaticSearch       accuracy and step
    progress : hears of each iteration and its largest relative residual

    Raises
    ------
    ModelError          whatever the start of a run would find wrong with the joints
    ConvergenceError    no equilibrium was found
    Source: Kelley & Keyes (1998) for the search.
    """
    search = StaticSearch() if search is None else search
    still = replace(system, bodies=tuple(_at_rest(placed) for placed in system.bodies))
    if system.bodies_of(FullBody):
        machine, configuration, *_ = consistent_start(FullSystem(still), time)
        statics, model = FullStatics(machine), machine.model
        frames = tuple(np.zeros(6) for _ in machine.interiors)
    else:
        compiled, configuration, *_ = consistent_start(CompiledMachine(still, build_model(still)), time)
        statics, model, frames = CompiledStatics(compiled), compiled.model, ()
    start = StaticState(configuration, np.zeros(len(model.active)), frames)
    found, iterations = search_equilibrium(statics, start, time, search, progress)
    multipliers = joint_multipliers(still, model.active, np.asarray(found.multipliers))
    return Equilibrium(_placed(still, found), _joint_forces(still, found, time, multipliers), iterations)


def _joint_forces(
    system: System, state: StaticState, time: float, multipliers: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """`joint_wrenches` of one instant at rest."""
    sizes = np.array([6 + placed.body.n_coordinates for placed in system.bodies])
    slices = tuple(
        slice(int(end - size), int(end)) for end, size in zip(np.cumsum(sizes), sizes, strict=True)
    )
    still = np.zeros((1, int(sizes.sum())))
    configuration = Configuration(*(np.asarray(part)[None] for part in state.configuration))
    motions = body_motions(system, slices, configuration, still, still)
    of_instant = {name: own[None] for name, own in multipliers.items()}
    forces = joint_wrenches(system, np.array([time]), motions, of_instant)
    return {name: force[0] for name, force in forces.items()}


def _at_rest(placed: Placed) -> Placed:
    none = np.zeros(3)
    return replace(placed, velocity=none, angular_velocity=none, coordinate_rates=np.zeros(0))


def _placed(system: System, state: StaticState) -> System:
    """The system with its bodies where the state says."""
    bodies, first = [], 0
    for index, placed in enumerate(system.bodies):
        after = first + placed.body.n_coordinates
        rotation = np.asarray(state.configuration.rotations[index])
        bodies.append(
            replace(
                placed,
                position=state.configuration.origins[index],
                rotation=np.linalg.svd(rotation)[0] @ np.linalg.svd(rotation)[2],
                coordinates=state.configuration.coordinates[first:after],
            )
        )
        first = after
    return replace(system, bodies=tuple(bodies))
