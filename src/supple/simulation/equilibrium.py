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
from supple.multibody.equations.consistent_start import consistent_start
from supple.multibody.equations.floating_solution import joint_forces
from supple.multibody.equations.static_search import StaticSearch, StaticState, search_equilibrium
from supple.multibody.full.full_system import FullSystem

__all__ = ["Equilibrium", "equilibrium"]


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A machine at rest.

    system       : System       its bodies placed and deformed as they rest: `simulate` starts there
    joint_forces : {name: (c,)} multipliers of each joint's equations
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
        machine, configuration, _ = consistent_start(FullSystem(still), time)
        statics, model = FullStatics(machine), machine.model
        frames = tuple(np.zeros(6) for _ in machine.interiors)
    else:
        compiled, configuration, _ = consistent_start(CompiledMachine(still, build_model(still)), time)
        statics, model, frames = CompiledStatics(compiled), compiled.model, ()
    start = StaticState(configuration, np.zeros(len(model.active)), frames)
    found, iterations = search_equilibrium(statics, start, time, search, progress)
    return Equilibrium(
        _placed(still, found), joint_forces(still, model.active, np.asarray(found.multipliers)), iterations
    )


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
