"""The linear equations of a machine about its equilibrium, without the joints' multipliers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
from scipy.sparse import block_diag, csr_array, eye_array
from scipy.spatial.transform import Rotation

from supple.arguments import checked_arguments
from supple.body import FullBody
from supple.equations import StaticSearch
from supple.equations.control_linearization import LinearControl
from supple.equations.static_search import carried_state
from supple.equations.steady_motion import (
    LinearEquations,
)
from supple.errors import ModelError
from supple.linearization.linear_machine import Array, FullMachine, LinearMachine
from supple.linearization.sparse_machine import SparseMachine
from supple.machine import GROUND, Joint, JointFriction, PrescribedRotation, Spin, System
from supple.methods.floating.full.linear_equations import SparseEquations
from supple.simulation.equations_of import equations_of
from supple.simulation.equilibrium import warn_of_rest
from supple.simulation.full_rest import full_rest, known_fulls, rest_errors
from supple.simulation.resting_state import RestingState, at_rest, placed_at_rest, resting_state

__all__ = ["linearize"]

_CONSTANT = 1e-6
"""Equations that change by more than this part as the machine turns on have no eigenvalues."""
_TURNED_ON = 0.7
"""rad, after which they are compared: no fraction of a turn that a machine is likely to repeat."""


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
    """Small motions of a machine about the equilibrium that is downhill from where its bodies are placed.

        M p'' + C p' + K p + G^T l = 0,     G p = 0     ->     M_y y'' + C_y y' + K_y y = 0,     p = N y

    The loops of controllers are closed, and their states stand beside the motion (`LinearMachine`).

    Full bodies leave it sparse, `A p = 0` with the conditions of their frames: a `SparseMachine`, of which
    `machine_modes` finds the slowest modes.

    Parameters
    ----------
    time : of the loads and laws, which are held; a driven joint between bodies that turn and bodies that
        stand has the spin's rate, whatever its law
    spin : Spin             of the machine, or of the bodies that it names
    search, fulls, progress : of the `equilibrium`; by the full bodies `machine_modes` says what the bases
        of the reduced ones cost

    Raises
    ------
    ModelError          a machine whose equations change as it turns
    ConvergenceError    no equilibrium
    """
    frictions = [load for load in system.loads if isinstance(load, JointFriction)]
    if frictions and spin is not None and spin.rate:
        raise ModelError(
            f"{frictions[0].label}: how the friction of what slides follows its force is not linearised; "
            "give it a preload, RevoluteFriction or PrismaticFriction, or leave it out"
        )
    found = resting_state(system, time=time, spin=spin, search=search, progress=progress)
    equations = found.equations.linear_equations(found.state, time)
    sparse = None
    if isinstance(equations, SparseEquations):
        sparse = SparseMachine(placed_at_rest(found), spin, time, equations)
        # The motions that are slow are those in which a change would be seen.
        basis = sparse.slow.motions
    else:
        basis = _free_motions(equations)
    projected = _Projected.of(equations, basis)
    if spin is not None and spin.rate:
        _check_constant(found, projected, basis, time, spin)
    if sparse is not None:
        return sparse
    return LinearMachine(
        system=placed_at_rest(found),
        spin=spin,
        time=time,
        mass=(projected.mass + projected.mass.T) / 2,
        damping=projected.damping,
        stiffness=projected.stiffness,
        basis=basis,
        full_mass=equations.mass,
        control=projected.control,
        full=_full_machine(found, known_fulls(system, fulls), time, spin, search or StaticSearch()),
    )


def _full_machine(
    found: RestingState,
    fulls: Mapping[str, FullBody],
    time: float,
    spin: Spin | None,
    search: StaticSearch,
) -> FullMachine | None:
    """The machine about the equilibrium that it has with all coordinates; None where that is not known."""
    full = full_rest(found, fulls, time, search)
    if full is None:
        return None
    errors = rest_errors(found, fulls, full)
    warn_of_rest(errors)
    if full.found is None:
        return None
    equations = full.found.equations.linear_equations(full.found.state, time)
    blocks, bodies = [], {}
    for placed, part in zip(found.system.bodies, full.found.equations.slices, strict=True):
        name = placed.body.name
        own: Any = eye_array(part.stop - part.start)
        if name in full.bases:
            own = block_diag([np.eye(6), full.bases[name].vectors])
            bodies[name] = slice(part.start + 6, part.stop)
        blocks.append(own)
    machine = SparseMachine(placed_at_rest(full.found), spin, time, equations)
    return FullMachine(machine, csr_array(block_diag(blocks)), bodies, errors)


class _Projected(NamedTuple):
    """Equations in independent coordinates."""

    mass: Array
    damping: Array
    stiffness: Array
    control: LinearControl

    @classmethod
    def of(cls, equations: LinearEquations | SparseEquations, basis: Array) -> _Projected:
        """`N^T M N` and the like, N (n, k)."""
        images = equations.mass @ basis, equations.damped(basis), equations.stiffness @ basis
        mass, damping, stiffness = (basis.T @ each for each in images)
        return cls(mass, damping, stiffness, equations.control.along(basis))


def _free_motions(equations: LinearEquations) -> Array:
    """`N` (n, k), the null space of `G`; its columns of the size of unit kinetic energy."""
    size = 1 / np.sqrt(np.diag(equations.mass))
    return size[:, None] * scipy.linalg.null_space(equations.constraint * size)


def _turned_on(found: RestingState, time: float, spin: Spin) -> System:
    """The machine later in its turn, its driven joints with it."""
    turn = Rotation.from_rotvec(_TURNED_ON * spin.axis).as_matrix()
    turning = found.turning.angular_velocities @ spin.axis != 0
    system = placed_at_rest(found)
    bodies = [
        replace(
            placed,
            position=spin.point + turn @ (placed.position - spin.point),
            rotation=turn @ placed.rotation,
        )
        if moves
        else placed
        for placed, moves in zip(system.bodies, turning, strict=True)
    ]

    def driven_on(joint: Joint) -> Joint:
        if not isinstance(joint, PrescribedRotation):
            return joint
        first, second = (
            end != GROUND and bool(turning[system.body_index(end.body)])
            for end in (joint.first, joint.second)
        )
        sense = np.sign(np.dot(joint.axis, spin.axis)) * (float(second) - float(first))
        return replace(joint, angle=float(joint.law(time)) + sense * _TURNED_ON)

    return replace(system, bodies=tuple(bodies), joints=tuple(map(driven_on, system.joints)))


def _check_constant(
    found: RestingState, projected: _Projected, basis: Array, time: float, spin: Spin
) -> None:
    """ModelError where the equations, or what is in balance, change as the machine turns."""
    system = _turned_on(found, time, spin)
    system = replace(system, bodies=tuple(map(at_rest, system.bodies)))
    later = equations_of(system, found.turning, time, found.equations.model.active)
    state, unbalanced = carried_state(later, time)
    equations = later.linear_equations(state, time)
    again, jacobian, masses = _Projected.of(equations, basis), equations.constraint, equations.mass.diagonal()
    size = np.sqrt(np.abs(np.diag(projected.stiffness)) + spin.rate**2 * np.diag(projected.mass))
    changes = {
        "mass": (again.mass - projected.mass) * spin.rate**2,
        "damping": (again.damping - projected.damping) * spin.rate,
        "stiffness": again.stiffness - projected.stiffness,
    }
    largest = {what: float(np.max(abs(change) / np.outer(size, size))) for what, change in changes.items()}
    largest["control"] = _changed(projected.control, again.control, size, spin.rate)
    opened = float(np.max(abs(jacobian @ basis) @ np.ones(basis.shape[1]), initial=0.0))
    # Where no motion of the basis is seen by a joint, rounding is compared with one of unit kinetic energy.
    reach = abs(basis).sum(axis=1) + 1 / np.sqrt(masses)
    largest["joints"] = opened / float(np.max(abs(jacobian) @ reach, initial=1e-300))
    largest["balance"] = unbalanced
    what = max(largest, key=lambda name: largest[name])
    if largest[what] > _CONSTANT:
        raise ModelError(
            f"the linear equations change as the machine turns by {_TURNED_ON:g} rad (the {what} by "
            f"{largest[what]:.2g} of its size), so that it has no eigenvalues: gravity or loads across the "
            "axis, and joints or springs between turning and standing parts that are not alike in all "
            "directions, must be left out, as must controllers that see the angle of the turn; or name the "
            "bodies that turn, Spin(bodies=..)"
        )


def _changed(control: LinearControl, again: LinearControl, size: Array, rate: float) -> float:
    """Largest change of what controllers read and push, over the size of each row and column."""

    def parts(own: LinearControl) -> tuple[Array, Array]:
        read = np.hstack([own.by_position / size, own.by_velocity * abs(rate) / size])
        return read, (own.forces / size[:, None]).T

    changes = [float(np.max(abs(again.by_state - control.by_state), initial=0.0)) / abs(rate)]
    for before, after in zip(parts(control), parts(again), strict=True):
        largest = np.max(abs(before), axis=1, initial=1e-300)
        changes.append(float(np.max(np.max(abs(after - before), axis=1, initial=0.0) / largest, initial=0.0)))
    return max(changes)
