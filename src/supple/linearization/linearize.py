"""Linear equations of a machine about its equilibrium, in independent coordinates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from supple.arguments import checked_arguments
from supple.body import FullBody
from supple.equations import StaticSearch
from supple.equations.control_linearization import LinearControl
from supple.errors import ModelError
from supple.linearization.linear_machine import FullMachine, LinearMachine
from supple.linearization.sparse_machine import SparseMachine
from supple.linearization.standing_axes import RotatingMachine, in_standing_axes
from supple.linearization.standing_error import StandingTurn, coordinates_of_bodies, expansion
from supple.machine import GROUND, JointFriction, Spin, System
from supple.methods.floating.full.linear_equations import SparseEquations
from supple.simulation.equilibrium import warn_of_rest, warn_of_rest_limits
from supple.simulation.full_rest import full_rest, known_fulls, rest_errors
from supple.simulation.rest_stability import free_motions
from supple.simulation.resting_state import RestingState, placed_at_rest, resting_state
from supple.simulation.turned_machine import (
    CONSTANT,
    equations_turned_on,
    refuse_other_speeds,
    refuse_turning_bushings,
    turning_bodies,
)

__all__ = ["linearize", "linearize_in_space"]

_NOT_IN_SPACE = (
    "the machine is not linearised in axes fixed in space: full bodies and controllers are not supported "
    "there (reduce the bodies, leave out the controllers), and joints must leave the same motions free at "
    "all angles; linearize describes it in co-rotating axes"
)
_TURNED_ON = 0.7
"""Rotation, rad, after which the equations are compared; it is no likely angle of symmetry."""


@checked_arguments
def linearize(
    system: System,
    *,
    time: float = 0.0,
    spin: Spin | None = None,
    search: StaticSearch | None = None,
    fulls: Mapping[str, FullBody] | Sequence[FullBody] | None = None,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> LinearMachine | SparseMachine:
    """Linearise a machine about its equilibrium, found as by `equilibrium` from the placement of the bodies.

        M p'' + C p' + K p + G^T l = 0,     G p = 0     ->     M_y y'' + C_y y' + K_y y = 0,     p = N y

    p are small motions of the bodies, l the Lagrange multipliers of the joint equations G p = 0, and y
    independent coordinates. Controllers are closed loops, whose states are additional unknowns
    (`LinearMachine`).

    The equations of a rotating machine are written in co-rotating axes if they are constant there, otherwise
    in standing axes (`in_standing_axes`). For example, a rotor on unequal bearings, or three or more equal
    blades on a flexible tower, have constant equations in standing axes. If the equations vary in both axes,
    the result is periodic (`Periodic`), and its modes are Floquet modes.

    For a machine with full bodies the result is a `SparseMachine`, whose constraints include the conditions
    of the frames of these bodies; `machine_modes` finds its slowest modes.

    Parameters
    ----------
    time : loads and laws are constant, with their values at this time; the rates of laws are zero. Exceptions
        between rotating and standing bodies: a driven joint has the rate of the spin, whatever its law, and
        the set-point of an AngleServo has the rate of its law
    spin : Spin             steady rotation of the machine, or of some of its bodies
    search, fulls, progress : as for `equilibrium`; from the full bodies `fulls`, `machine_modes` computes the
        basis errors of the reduced bodies

    Raises
    ------
    ModelError          a machine without free motions. A rotating machine with an equilibrium that varies
                        with the angle, with a drive at another speed, with joint friction, or with a bushing
                        that resists tilt between a rotating and a standing body. A rotating machine with
                        full bodies or controllers whose equations vary with the angle
    ConvergenceError    no equilibrium
    Warns ValidityWarning if a body exceeds a limit of its kinematics at the equilibrium.
    """
    return _linearized(system, time, spin, search, fulls, progress, is_asked_in_space=False)


@checked_arguments
def linearize_in_space(
    system: System,
    *,
    spin: Spin,
    time: float = 0.0,
    search: StaticSearch | None = None,
    fulls: Mapping[str, FullBody] | Sequence[FullBody] | None = None,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> LinearMachine:
    """Small motions of a rotating machine in standing axes, also where they are constant in co-rotating axes.

    For frequency responses of a rotor between ports whose directions are fixed in space, as at the tip of a
    tool. Parameters and errors as for `linearize`; ModelError for full bodies and controllers.
    """
    found = _linearized(system, time, spin, search, fulls, progress, is_asked_in_space=True)
    assert isinstance(found, LinearMachine)  # machines with full bodies are refused
    return found


def _linearized(
    system: System,
    time: float,
    spin: Spin | None,
    search: StaticSearch | None,
    fulls: Mapping[str, FullBody] | Sequence[FullBody] | None,
    progress: Callable[[int, float], None],
    *,
    is_asked_in_space: bool,
) -> LinearMachine | SparseMachine:
    frictions = [load for load in system.loads if isinstance(load, JointFriction)]
    if frictions and spin is not None and spin.rate:
        raise ModelError(
            f"{frictions[0].label}: friction that depends on the joint force cannot be linearised; "
            "give it a preload, RevoluteFriction or PrismaticFriction, or leave it out"
        )
    known, search = known_fulls(system, fulls), search or StaticSearch()
    found = resting_state(system, time=time, spin=spin, search=search, progress=progress)
    placed, sparse = placed_at_rest(found), None
    warn_of_rest_limits(placed, found.solution(time), known)
    if spin is not None and spin.rate:
        refuse_other_speeds(found, time, spin)
        refuse_turning_bushings(found, spin)
    equations = found.equations.linear_equations(found.state, time)
    if isinstance(equations, SparseEquations):
        sparse = SparseMachine(placed, spin, time, equations)
        # Whether the equations vary with the angle is seen in the slow motions.
        basis = sparse.slow.motions
    else:
        basis = free_motions(equations)
        if not basis.shape[1]:
            raise ModelError(
                "the joints leave the machine no free motion, and its bodies do not deform: it has no "
                "linear equations and no modes. Leave a motion free (a joint with more freedom, or a "
                "spring in place of a joint), or give a body that deforms"
            )
    linear = LinearMachine.along(basis, equations, placed, spin, time)
    if spin is not None and spin.rate:
        what, change = _change(found, linear, spin)
        if change > CONSTANT or is_asked_in_space:
            refusal = _refusal(found, spin, what, change) if change > CONSTANT else _NOT_IN_SPACE
            if sparse is not None:
                raise ModelError(refusal)
            standing = in_standing_axes(found, time, spin, refusal)
            if standing.periodic is not None:
                return standing
            return replace(standing, full=_full_machine(found, known, time, spin, search, is_in_space=True))
    if sparse is not None:
        return sparse
    return replace(linear, full=_full_machine(found, known, time, spin, search))


def _full_machine(
    found: RestingState,
    fulls: Mapping[str, FullBody],
    time: float,
    spin: Spin | None,
    search: StaticSearch,
    *,
    is_in_space: bool = False,
) -> FullMachine | None:
    """The machine with full bodies in place of the reduced ones, about its own equilibrium.

    None without full bodies, or if this equilibrium is not found.
    Warns BasisWarning of reduced bodies with large errors at the equilibrium.
    """
    full = full_rest(found, fulls, time, search)
    if full is None:
        return None
    errors = rest_errors(found, fulls, full)
    warn_of_rest(errors)
    if full.found is None:
        return None
    equations = full.found.equations.linear_equations(full.found.state, time)
    vectors = {name: basis.vectors for name, basis in full.bases.items()}
    machine = SparseMachine(placed_at_rest(full.found), spin, time, equations)
    standing = None
    if is_in_space and spin is not None:
        own = {name: body for name, body in fulls.items() if name in vectors}
        bodies = [placed.body for placed in full.found.system.bodies]
        standing = StandingTurn(RotatingMachine(full.found, time, spin, bodies), own, vectors)
    parts = coordinates_of_bodies(full.found, vectors)
    return FullMachine(machine, expansion(full.found, vectors), parts, errors, standing)


def _change(found: RestingState, linear: LinearMachine, spin: Spin) -> tuple[str, float]:
    """The quantity that varies most as the machine rotates, and its variation."""
    equations, unbalanced = equations_turned_on(found, linear.time, spin, _TURNED_ON)
    basis, jacobian = linear.basis, equations.constraint
    again = LinearMachine.along(basis, equations, linear.system, spin, linear.time)
    size = np.sqrt(np.abs(np.diag(linear.stiffness)) + spin.rate**2 * np.diag(linear.mass))
    changes = {
        "mass": (again.mass - linear.mass) * spin.rate**2,
        "damping": (again.damping - linear.damping) * spin.rate,
        "stiffness": again.stiffness - linear.stiffness,
    }
    largest = {what: float(np.max(abs(change) / np.outer(size, size))) for what, change in changes.items()}
    largest["control"] = _changed(linear.control, again.control, size, spin.rate)
    opened = float(np.max(abs(jacobian @ basis) @ np.ones(basis.shape[1]), initial=0.0))
    # If the basis does not move any joint, the rounding is that of a motion of unit kinetic energy.
    reach = abs(basis).sum(axis=1) + 1 / np.sqrt(equations.mass.diagonal())
    largest["joints"] = opened / float(np.max(abs(jacobian) @ reach, initial=1e-300))
    largest["balance"] = unbalanced
    return max(largest.items(), key=lambda item: item[1])


def _refusal(found: RestingState, spin: Spin, what: str, change: float) -> str:
    held = next((joint for joint in found.system.joints if GROUND in (joint.first, joint.second)), None)
    hub = ""
    if what == "joints" and held is not None and turning_bodies(found, spin).all():
        hub = (
            f". All bodies rotate, and joint '{held.name}' connects one to the ground: if there is a hub, "
            "make it a rigid body, driven by a joint about the axis of the spin, and connect the joint to it"
        )
    return (
        f"the linear equations change as the machine rotates by {_TURNED_ON:g} rad (the {what} by "
        f"{change:.2g} of its size), and neither standing axes nor Floquet theory apply. Remove what "
        "causes the change: gravity or loads normal to the axis, unbalance of rotors, controllers, full "
        "bodies, or joints whose free motions depend on the angle; or list the rotating bodies, "
        f"Spin(bodies=..){hub}"
    )


def _changed(control: LinearControl, again: LinearControl, size: np.ndarray, rate: float) -> float:
    """Largest change of the readings and forces of controllers, each relative to its own size."""

    def parts(own: LinearControl) -> tuple[np.ndarray, np.ndarray]:
        read = np.hstack([own.by_position / size, own.by_velocity * abs(rate) / size])
        return read, (own.forces / size[:, None]).T

    changes = [float(np.max(abs(again.by_state - control.by_state), initial=0.0)) / abs(rate)]
    for before, after in zip(parts(control), parts(again), strict=True):
        largest = np.max(abs(before), axis=1, initial=1e-300)
        changes.append(float(np.max(np.max(abs(after - before), axis=1, initial=0.0) / largest, initial=0.0)))
    return max(changes)
