"""Equilibrium of a machine: where it rests, or how it turns steadily, under its loads at one time."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from supple.arguments import checked_arguments
from supple.body import FullBody
from supple.equations.static_search import StaticSearch
from supple.errors import BasisWarning
from supple.integrate import Solution
from supple.machine import Spin, System
from supple.progress import with_progress_bar
from supple.simulation.full_rest import RestError, full_rest, holds_all, known_fulls, rest_errors
from supple.simulation.rest_stability import is_stable
from supple.simulation.resting_state import (
    RestingState,
    placed_at_rest,
    resting_state,
)
from supple.summary import Summarized, Summary

__all__ = ["Equilibrium", "equilibrium"]

LARGEST_ERROR = 0.01
"""Of a displacement: what is warned of."""


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Summarized):
    """A machine at rest, or turning steadily.

    system     : System     its bodies placed, moving and deformed as they are: `simulate` starts there
    solution   : Solution   the same as a motion of one instant, for what reads motions
    iterations : int        that the search took
    errors : RestError      what its basis costs, by name of the reduced body whose full one is known
    full : (System, Solution)   the same rest with all coordinates of the bodies whose full ones are known;
                            None where none is, or no such rest was found
    stable : bool | None    whether the tangent stiffness, in axes that turn along, is positive on the motions
                            that the joints leave free; None where it does not decide: loads that follow the
                            bodies, controllers, gyroscopic forces that may hold two directions of fall
    is_held : bool          whether the joints leave no rigid motion free
    """

    system: System
    solution: Solution
    iterations: int
    errors: Mapping[str, RestError] = field(default_factory=dict)
    full: tuple[System, Solution] | None = None
    stable: bool | None = None
    is_held: bool = False

    def summary(self) -> Summary:
        """Stability, what the bases cost, and the size of the force of each joint."""
        stable = {True: "stable", False: "not stable", None: "stability not decided"}[self.stable]
        rows = [("found", f"after {self.iterations} iterations; {stable}")]
        for name, error in self.errors.items():
            share = f"{100 * error.relative:.2g} % of the largest displacement"
            known = f"{error.worst:.2g} at the worst node, {share}"
            unknown = "not known: no rest with all coordinates"
            rows.append((f"error of {name}", known if error.known else unknown))
        for name, force in self.joint_forces.items():
            size, moment = np.linalg.norm(force[:3]), np.linalg.norm(force[3:])
            rows.append((f"joint {name}", f"force {size:.4g}, moment {moment:.4g}"))
        return Summary(f"Equilibrium of a machine of {len(self.system.bodies)} bodies, {stable}", rows)

    @property
    def joint_forces(self) -> Mapping[str, np.ndarray]:
        """Force and moment (6,) on each joint's second end, as in a `Solution`."""
        return {name: forces[0] for name, forces in self.solution.joint_forces.items()}


@checked_arguments
@with_progress_bar("searching the equilibrium")
def equilibrium(
    system: System,
    *,
    time: float = 0.0,
    spin: Spin | None = None,
    search: StaticSearch | None = None,
    fulls: Mapping[str, FullBody] | Sequence[FullBody] | None = None,
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
    fulls : FullBody            the bodies with all their coordinates, which reduced ones were made of: one
        factorisation gives the error of the bases (`Equilibrium.errors`). None: those that the reduced bodies
        know, all but those read from files; (): the factorisation is saved, and nothing is known of it
    progress : called with each iteration and its largest relative residual

    Controllers act as in a run, and their states rest with the machine: `f(0, q, z) = 0`, from which those of
    the equilibrium's system begin.

    Raises
    ------
    ModelError          whatever the start of a run would find wrong with the joints; a controller that is
        sampled; a full body that is not the one that was reduced, or of a body that is not reduced; an
        intrinsic body whose support holds it against the spin
    ConvergenceError    no equilibrium was found, or a controller's state has none
    Warns BasisWarning where a body lacks 1 % of its largest displacement or more.
    Source: [KelleyKeyes1998] for the search.
    """
    search = search or StaticSearch()
    known = known_fulls(system, fulls)
    found = resting_state(system, time=time, spin=spin, search=search, progress=progress)
    full = full_rest(found, known, time, search)
    errors = {} if full is None else rest_errors(found, known, full)
    warn_of_rest(errors)
    balanced = None if full is None or full.found is None else full.found
    return Equilibrium(
        placed_at_rest(found),
        _one_instant(found, time),
        found.iterations,
        errors,
        None if balanced is None else (placed_at_rest(balanced), _one_instant(balanced, time)),
        is_stable(found, time),
        holds_all(found.system, found.equations.model),
    )


def warn_of_rest(errors: Mapping[str, RestError]) -> None:
    """BasisWarning for each body whose basis lacks a part of the rest that matters."""
    for name, error in errors.items():
        if not error.known:
            seen = "no equilibrium was found with all its coordinates"
        elif error.relative >= LARGEST_ERROR:
            seen = (
                f"at rest a node is off by {error.worst:.2g}, {100 * error.relative:.2g} % of the largest "
                f"displacement, and the strain by {100 * error.strain:.2g} %"
            )
        else:
            continue
        warnings.warn(
            f"body '{name}': {seen}: its basis lacks the shape. {REMEDY}", BasisWarning, stacklevel=3
        )


REMEDY = (
    "Let the reduction correct itself (accuracy = { relative = 1e-3 }; in Python "
    "correct_at_rest), or keep more modes"
)


def _one_instant(found: RestingState, time: float) -> Solution:
    """The equilibrium as a motion of one instant."""
    return found.equations.solution(found.state, time, found.iterations)
