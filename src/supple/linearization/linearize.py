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
from supple.equations.build_model import build_model
from supple.equations.consistent_start import placed_configuration
from supple.equations.control_linearization import LinearControl, control_at_rest, unrest
from supple.equations.coordinate_scales import position_scale
from supple.equations.joint_force import constraint_rows
from supple.equations.static_search import StaticState
from supple.equations.steady_motion import (
    LinearEquations,
    steady_motion,
    work_of_turning,
)
from supple.errors import ModelError
from supple.linearization.linear_machine import Array, FullMachine, LinearMachine
from supple.linearization.sparse_machine import SparseMachine
from supple.machine import GROUND, Joint, PrescribedRotation, Spin, System
from supple.machine.forces import JointFriction
from supple.methods.floating.compiled.compiled_machine import CompiledMachine
from supple.methods.floating.compiled.statics import CompiledStatics, balanced
from supple.methods.floating.full.statics import FullStatics, carried_state
from supple.methods.intrinsic.line_statics import LineStatics, line_statics
from supple.simulation.equilibrium import warn_of_rest
from supple.simulation.full_rest import full_rest, known_fulls, rest_errors
from supple.simulation.resting_state import RestingState, at_rest, placed_at_rest, resting_state
from supple.simulation.seen_machine import full_system

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
    if system.bodies_of(FullBody):
        return _sparse(found, time, spin)
    equations = _equations(found, time)
    basis = _free_motions(equations)
    projected = _Projected.of(equations, basis)
    if spin is not None and spin.rate:
        later, left = _carried(_turned_on(found, time, spin), found, time)
        again = _equations(later, time)
        masses = np.diag(equations.mass)
        changed = _Projected.of(again, basis)
        _check_constant(projected, changed, again.jacobian, masses, basis, spin, left)
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
    statics = FullStatics(full_system(full.found.system, full.found.model.active), full.found.turning)
    equations = statics.linear_equations(full.found.state, time)
    blocks, bodies = [], {}
    for placed, part in zip(found.system.bodies, full.found.slices, strict=True):
        name = placed.body.name
        own: Any = eye_array(part.stop - part.start)
        if name in full.bases:
            own = block_diag([np.eye(6), full.bases[name].vectors])
            bodies[name] = slice(part.start + 6, part.stop)
        blocks.append(own)
    machine = SparseMachine(placed_at_rest(full.found), spin, time, equations)
    return FullMachine(machine, csr_array(block_diag(blocks)), bodies, errors)


def _sparse(found: RestingState, time: float, spin: Spin | None) -> SparseMachine:
    """The linearised machine with full bodies."""
    active, turning = found.model.active, found.turning
    equations = FullStatics(full_system(found.system, active), turning).linear_equations(found.state, time)
    machine = SparseMachine(placed_at_rest(found), spin, time, equations)
    if spin is not None and spin.rate:
        turned = _turned_on(found, time, spin)
        there = full_system(turned, active)
        state, left = carried_state(
            there, turning, time, found.state._replace(configuration=placed_configuration(turned))
        )
        later = FullStatics(there, turning).linear_equations(state, time)
        # The motions that are slow are those in which a change would be seen.
        basis = machine.slow.motions
        parts = replace(machine, equations=later).along(basis)
        again = _Projected(parts.mass, parts.damping, parts.stiffness, parts.control)
        parts = machine.along(basis)
        _check_constant(
            _Projected(parts.mass, parts.damping, parts.stiffness, parts.control),
            again,
            later.constraint,
            later.mass.diagonal(),
            basis,
            spin,
            left,
        )
    return machine


def _equations(found: RestingState, time: float) -> LinearEquations:
    return found.machine.linear_equations(found.state, time)


def _carried(system: System, found: RestingState, time: float) -> tuple[RestingState, float]:
    """A system where it is placed, its joints carrying what is unbalanced; and what part they cannot."""
    if isinstance(found.machine, LineStatics):
        still = replace(system, bodies=tuple(map(at_rest, system.bodies)))
        there = line_statics(still, found.turning, time, found.model.active)
        state, left = there.carried_state()
        return found._replace(machine=there, state=state), left
    model = build_model(system, found.model.active)
    configuration, none = placed_configuration(system), np.zeros(len(found.model.active))
    motion = steady_motion(model, found.turning, time, configuration, none, found.state.control)
    terms = balanced(model, motion)
    rows = np.asarray(constraint_rows(model, terms.linearization.joints))
    weights = np.asarray(position_scale(model))
    unbalanced = weights * np.asarray(terms.residual)
    carried = weights[:, None] * rows.T
    multipliers = np.linalg.lstsq(carried, -unbalanced, rcond=None)[0]
    largest = max(
        float(np.linalg.norm(weights * part)) for part in (terms.inertia, terms.internal, terms.applied)
    )
    # What is in balance may vanish, as the torque on a rotor that turns freely does: rounding is left then.
    largest = max(largest, _CONSTANT * work_of_turning(model, found.turning))
    left = float(np.linalg.norm(unbalanced + carried @ multipliers)) / (largest or 1.0)
    rest = unrest(
        system, control_at_rest(model, motion), position_scale(model), motion.velocity, found.state.control
    )
    state = StaticState(configuration, multipliers, control=found.state.control)
    machine = CompiledStatics(CompiledMachine(system, model), found.turning)
    return found._replace(model=model, state=state, machine=machine), max(left, *rest.values(), 0.0)


class _Projected(NamedTuple):
    """Equations in independent coordinates."""

    mass: Array
    damping: Array
    stiffness: Array
    control: LinearControl

    @classmethod
    def of(cls, equations: LinearEquations, basis: Array) -> _Projected:
        """`N^T M N` and the like of dense equations, N (n, k)."""
        parts = equations.mass, equations.damping, equations.stiffness
        mass, damping, stiffness = (basis.T @ part @ basis for part in parts)
        return cls(mass, damping, stiffness, equations.control.along(basis))


def _free_motions(equations: LinearEquations) -> Array:
    """`N` (n, k), the null space of `G`; its columns of the size of unit kinetic energy."""
    size = 1 / np.sqrt(np.diag(equations.mass))
    return size[:, None] * scipy.linalg.null_space(equations.jacobian * size)


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
    projected: _Projected,
    again: _Projected,
    jacobian: Any,
    masses: Array,
    basis: Array,
    spin: Spin,
    unbalanced: float,
) -> None:
    """ModelError where the equations, or what is in balance, change as the machine turns."""
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
