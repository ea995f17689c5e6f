"""Equilibrium of a machine, at rest or in steady rotation, under its loads at one time."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from supple.arguments import checked_arguments
from supple.body import FullBody
from supple.equations.checks.validity import is_rotor, watch
from supple.equations.static_search import StaticSearch
from supple.errors import BasisWarning
from supple.integrate import FramedMotion, Solution, Validity
from supple.machine import Spin, System
from supple.progress import with_progress_bar
from supple.simulation.full_rest import (
    EquilibriumError,
    fixes_rigid_motion,
    full_rest,
    known_fulls,
    rest_errors,
)
from supple.simulation.rest_stability import is_stable
from supple.simulation.resting_state import placed_at_rest, resting_state
from supple.simulation.turned_machine import warn_of_varying_loads
from supple.summary import Summarized, Summary

__all__ = ["Equilibrium", "equilibrium"]

LARGEST_ERROR = 0.01
"""Basis error from which a warning is issued, relative to the largest displacement."""


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Summarized):
    """A machine at rest, or in steady rotation.

    system     : System     with the poses, velocities and deformation of its bodies, for a run to start from
    solution   : Solution   the same state as a motion with one output time
    iterations : int        number of iterations of the search
    errors : EquilibriumError      basis error of each reduced body with a known full body, by name
    full : (System, Solution)   the equilibrium with all coordinates of the reduced bodies whose full bodies
                are known; None without such bodies, or if it was not found
    stable : bool | None    whether the tangent stiffness, in co-rotating axes, has no negative eigenvalue on
                the motions that the joints leave free. None if that does not decide: with follower loads,
                controllers, or gyroscopic forces and an even number of unstable directions
    is_held : bool          whether the joints fix all rigid motion
    """

    system: System
    solution: Solution
    iterations: int
    errors: Mapping[str, EquilibriumError] = field(default_factory=dict)
    full: tuple[System, Solution] | None = None
    stable: bool | None = None
    is_held: bool = False

    def summary(self) -> Summary:
        """Stability, basis errors, and the size of the force of each joint."""
        stable = {True: "stable", False: "not stable", None: "stability not decided"}[self.stable]
        rows = [("found", f"after {self.iterations} iterations; {stable}")]
        for name, error in self.errors.items():
            share = f"{100 * error.relative:.2g} % of the largest displacement"
            known = f"{error.worst:.2g} at the worst node, {share}"
            unknown = "not known: no equilibrium with all coordinates"
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
@with_progress_bar("searching for the equilibrium")
def equilibrium(
    system: System,
    *,
    time: float = 0.0,
    spin: Spin | None = None,
    search: StaticSearch | None = None,
    fulls: Mapping[str, FullBody] | Sequence[FullBody] | None = None,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> Equilibrium:
    """Equilibrium of a machine, at rest or in steady rotation, under gravity, loads and laws at one time.

        I(q, w) + f(q) + G(q)^T lambda = Q(t, q),     g(q, t) = 0

    with the internal forces f, the joint forces G^T lambda, and gravity and loads Q. I is the inertia force
    of the `spin` with the angular velocity w, zero without a spin. The search starts from the placement of
    the bodies and descends in potential energy, so that it normally ends in a stable equilibrium nearby.
    Initial velocities of the bodies are ignored; velocities of the equilibrium are those of the spin. Loads
    and gravity that do not rotate with the machine have the values and directions of `time`.

    Parameters
    ----------
    time : time at which loads and laws are evaluated
    spin : Spin       of the machine, or of the bodies listed in it; all other bodies are at rest
    search : StaticSearch       accuracy and step
    fulls : FullBody            full bodies of the reduced bodies, for the basis errors
        (`Equilibrium.errors`), which need one factorisation. None: those to which the reduced bodies refer
        (bodies read from files refer to none); (): no factorisation and no estimate
    progress : called at each iteration with its number and its largest relative residual

    Controllers act as in a run, and the rates of their states z are zero. The controllers of the resulting
    system begin with these states.

    Raises
    ------
    ModelError          the errors of joints at the start of a run; a sampled controller; a full body that
                        does not belong to a reduced body of the machine; an intrinsic body whose support
                        prevents the spin; a joint between rotating and fixed bodies that prevents it; a
                        table that has no value at `time`
    ConvergenceError    no equilibrium was found, of the machine or of a controller's states

    Warns
    -----
    BasisWarning        the basis error of a body is unknown, or 1 % of its largest displacement or more
    ValidityWarning     a body exceeds a limit of its kinematics; the basis error does not contain this error.
                        A spin, with loads for which the equilibrium is not the same at all angles
    Source: [KelleyKeyes1998] for the search.
    """
    search = search or StaticSearch()
    known = known_fulls(system, fulls)
    found = resting_state(system, time=time, spin=spin, search=search, progress=progress)
    full = full_rest(found, known, time, search)
    errors = {} if full is None else rest_errors(found, known, full)
    warn_of_rest(errors)
    balanced = None if full is None or full.found is None else full.found
    placed, still = placed_at_rest(found), found.solution(time)
    warn_of_rest_limits(placed, still, known)
    warn_of_varying_loads(found, time, spin)
    return Equilibrium(
        placed,
        still,
        found.iterations,
        errors,
        None if balanced is None else (placed_at_rest(balanced), balanced.solution(time)),
        is_stable(found, time),
        fixes_rigid_motion(found.system, found.equations.model),
    )


def warn_of_rest(errors: Mapping[str, EquilibriumError]) -> None:
    """BasisWarning for each body whose basis error at equilibrium is large or unknown."""
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


def warn_of_rest_limits(system: System, solution: Solution, stated: Container[str]) -> None:
    """ValidityWarning of every limit of `watch` that the bodies exceed at rest or in steady rotation.

    A linear body that is a rotor may have any spin: centrifugal force has no resultant in it.

    system, solution : in equilibrium, with the velocities of its steady rotation
    stated : bodies with an estimate of the basis error, which contains stiffness missing in a basis
    """
    monitor = watch(system, Validity())
    peaks = monitor.peaks(solution)
    for body in (placed.body for placed in system.bodies if placed.body.name in peaks):
        motion = solution.motion(body.name, FramedMotion)
        if is_rotor(body, motion, 0) if body.is_linear else body.name in stated:
            peaks[body.name] = peaks[body.name]._replace(spin=0.0)
    monitor.report(peaks)


REMEDY = (
    "Let the reduction correct itself (accuracy = { relative = 1e-3 }; in Python "
    "correct_at_rest), or keep more modes"
)
