"""Linear state-space equations of a machine about its equilibrium."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import scipy.linalg

from supple.algebra.rotation import rotation_log
from supple.equations.compiled_machine import CompiledStart, compiled_start
from supple.equations.configuration import advance
from supple.equations.steady_motion import in_turning_axes
from supple.errors import ModelError
from supple.export.linear.small_motions import MotionChanges, SmallMotions, small_motions, varies_in_time
from supple.integrate import Run
from supple.linearization import LinearMachine, linearize
from supple.machine import JointFriction, PrismaticFriction, RevoluteFriction, System
from supple.quantities import Quantity
from supple.stepping.external_inputs import Driven, external_inputs
from supple.stepping.sensed_machine import SensedMachine
from supple.stepping.sensed_outputs import SensedOutputs, sensed_outputs
from supple.stepping.variables import Variable, check_names
from supple.units import UNNAMED, UnitSystem

Array = np.ndarray
_SMALL = 0.1
"""Largest relative difference of linear and nonlinear accelerations at the start; above it, ModelError."""
_TURNED = 1.0
"""Rotation of a body, rad, at which the matrices are compared with those at the equilibrium."""
_INSTANTS = 100
"""Number of times at which the rotation of the bodies is examined."""
_CHANGED, _ROUNDING = 0.01, 1e-9
"""Relative change above which matrices are not constant, and relative change that counts as rounding."""

_ROUNDED = 1e-12
"""Rotation, rad, that counts as rounding of a position."""


@dataclass(frozen=True, eq=False)
class LinearForm:
    """State-space form `x' = A x + B (u - u_0)`, `w = w_0 + C x + D (u - u_0)`.

    a : (m, m)    b : (m, i)    c : (o, m)    d : (o, i)
    rest : (o,) w_0, outputs in the equilibrium
    state : (m,) x at the start
    inputs, outputs : variables with their values at the start; the values of the inputs are u_0
    left_out : sensors that cannot be outputs, because JAX cannot trace them
    time, size, duration : start time, time step and duration of the run
    deviation : relative difference between the linear and the nonlinear accelerations at the start
    """

    a: Array
    b: Array
    c: Array
    d: Array
    rest: Array
    state: Array
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    left_out: tuple[str, ...]
    time: float
    size: float
    duration: float
    deviation: float


def linear_form(
    system: System,
    run: Run,
    sensors: Sequence[Quantity] = (),
    inputs: Mapping[str, Driven] = MappingProxyType({}),
    *,
    input_units: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> LinearForm:
    """The linear form of a machine of rigid and reduced bodies about its equilibrium.

        N^T (M p'' + C p' + K p) = N^T (f_u u + H z),   p = N y,   G^T l = -(M p'' + C p' + K p - f_u u - H z)

    p is the small motion of the bodies, l the change of the joint forces, u the change of the inputs, f_u the
    loads per unit input, and H the forces per unit state z of the controllers. N spans the motions that the
    joints allow. The state is x = (e, e', z), where y = V e with the undamped modes V. The states are scaled
    by powers of two to balance the rows and columns of A. Outputs are linear in p, p', p'', in the joint
    forces l and in the inputs u. Arguments are those of `step_program`.

    Raises
    ------
    ModelError          no linear form: bodies that are neither rigid nor reduced, stops, friction, prescribed
                        motions as inputs, loads that vary with time and are no inputs; a start far from the
                        equilibrium; bodies that rotate so far that the matrices change; no output
    ConvergenceError    no equilibrium is found
    """
    _check(system, inputs)
    given = external_inputs(system, inputs, input_units, run.start)
    machine = linearize(given.system, time=run.start, fulls=())
    assert isinstance(machine, LinearMachine)
    rest, begun = compiled_start(machine.system, run.start), compiled_start(given.system, run.start)
    given.check_read(rest.model)
    if varies_in_time(rest, run.start, run.start + run.duration):
        raise ModelError(
            "loads, prescribed motions or controllers vary with time, and the matrices of a linear machine "
            "are constant: make their laws inputs (--input NAME), or constant; for a prescribed motion "
            "export the nonlinear machine"
        )
    seen = SensedMachine(machine.system, machine.system)
    sensed = sensed_outputs(seen, given.sensors(sensors), units)
    check_names(given.variables, sensed.variables)
    small = small_motions(rest, run.start, given, sensed)
    a, b, changes = _equations(machine, small)
    _, read = small.along(changes)
    balanced, (scale, _) = scipy.linalg.matrix_balance(a, permute=False, separate=True)
    m = len(a)
    state, deviation = _start(machine, small, changes, rest, begun)
    if deviation > _SMALL:
        raise ModelError(
            "the machine starts too far from its equilibrium for a linear form: its initial accelerations "
            f"differ by {100 * deviation:.0f} % from the linear ones; start closer to the equilibrium "
            '(start = "equilibrium"), or export the nonlinear machine'
        )
    turned = _turned(balanced, scale, state, changes, rest, run.duration)
    if turned is not None:
        _check_unchanged(changes, small, small_motions(turned, run.start, given, sensed), turned)
    c, d = read[:, :m] * scale, read[:, m:]
    state = state / scale
    first = small.rest + c @ state
    return LinearForm(
        a=balanced,
        b=b / scale[:, None],
        c=c,
        d=d,
        rest=small.rest,
        state=state,
        inputs=given.variables,
        outputs=_named(sensed, first),
        left_out=sensed.left_out,
        time=float(run.start),
        size=float(run.step_control.first),
        duration=float(run.duration),
        deviation=deviation,
    )


def _named(sensed: SensedOutputs, values: Array) -> tuple[Variable, ...]:
    pairs = zip(sensed.variables, values, strict=True)
    return tuple(replace(variable, start=float(value)) for variable, value in pairs)


def _equations(machine: LinearMachine, small: SmallMotions) -> tuple[Array, Array, MotionChanges]:
    """A and B for states (e, e', z), and changes of the machine per unit of these states and inputs."""
    control, k, n_inputs = machine.control, machine.size, small.outputs.inputs.shape[1]
    symmetric = (machine.stiffness + machine.stiffness.T) / 2
    modes = scipy.linalg.eigh(symmetric, machine.mass)[1]  # V^T M V = 1
    shapes = machine.basis @ modes
    own = control.along(modes)
    pushed = -shapes.T @ small.residual.inputs
    rows = [-modes.T @ machine.stiffness @ modes, -modes.T @ machine.damping @ modes, own.forces, pushed]
    accelerations = np.hstack(rows)
    m = 2 * k + control.size
    a = np.vstack(
        [
            np.eye(k, m, k),
            accelerations[:, :m],
            np.hstack([own.by_position, own.by_velocity, own.by_state]),
        ]
    )
    b = np.vstack([np.zeros((k, n_inputs)), pushed, np.zeros((control.size, n_inputs))])
    every = np.eye(m + n_inputs)
    states = np.split(every, [k, 2 * k, m])
    changes = MotionChanges(
        position=shapes @ states[0],
        velocity=shapes @ states[1],
        acceleration=shapes @ accelerations,
        control=states[2],
        reactions=None,
        inputs=states[3],
    )
    return a, b, changes


def _start(
    machine: LinearMachine,
    small: SmallMotions,
    changes: MotionChanges,
    rest: CompiledStart,
    begun: CompiledStart,
) -> tuple[Array, float]:
    """States (m,) at the start, and the relative difference between linear and nonlinear accelerations there.

    The norm is that of the kinetic energy. The reference is the norm of the nonlinear accelerations. Against
    rounding errors, the reference is at least 1e-6 of the norm of the accelerations that joint forces and
    states cause alone, and at least the largest accelerations that small rotations of rounding cause.
    """
    axes = in_turning_axes(rest.model, rest.configuration)
    apart = _apart(rest, begun)
    moved = np.linalg.lstsq(changes.position[:, : machine.size], apart, rcond=None)[0]
    rates = np.linalg.lstsq(changes.position[:, : machine.size], axes.T @ begun.velocity, rcond=None)[0]
    control = (
        []
        if begun.control is None or rest.control is None
        else [
            np.asarray(one)[: np.size(law.initial)] - np.asarray(other)[: np.size(law.initial)]
            for one, other, law in zip(
                begun.control.states, rest.control.states, rest.model.controllers, strict=True
            )
        ]
    )
    state = np.concatenate([moved, rates, *control])
    own = in_turning_axes(begun.model, begun.configuration).T @ begun.acceleration
    linear = changes.acceleration[:, : len(state)] @ state

    mass = machine.full_mass
    assert isinstance(mass, np.ndarray)  # sparse for full bodies only

    def size(accelerations: Array) -> float:
        return float(np.sqrt(accelerations @ mass @ accelerations))

    # Accelerations by the reactions alone, as the scale below which a difference is rounding.
    carried = np.linalg.solve(mass, small.residual.reactions @ rest.multipliers)
    most = size(carried) + size(np.abs(changes.acceleration[:, : len(state)]) @ np.abs(state))
    turns = [part.start + 3 + k for part in rest.model.slices for k in range(3)]
    rounding = _ROUNDED * np.sqrt(mass[turns, turns].max())
    stiffest = max(map(size, changes.acceleration[:, : machine.size].T), default=0.0)
    return state, size(own - linear) / max(size(own), 1e-6 * most, rounding * stiffest, 1e-300)


def _turned(
    a: Array, scale: Array, state: Array, changes: MotionChanges, rest: CompiledStart, duration: float
) -> CompiledStart | None:
    """The machine when its free motion has rotated a body by one radian; None if no body rotates so far.

    a : A for the states divided by `scale`, whose exponential is accurate
    """
    model, m = rest.model, len(state)
    places = [part.start + 3 + k for part in model.slices for k in range(3)]
    position, velocity = changes.position[:, :m] * scale, changes.velocity[:, :m] * scale

    def angle(at: Array) -> float:
        return float(np.linalg.norm((position[places] @ at).reshape(-1, 3), axis=1).max())

    state, size = state / scale, duration / _INSTANTS
    step = scipy.linalg.expm(a * size)
    for _ in range(_INSTANTS):
        after = step @ state
        if angle(after) > _TURNED:
            begun = angle(state)
            part = np.clip((_TURNED - begun) / (angle(after) - begun), 0.0, 1.0)
            state = scipy.linalg.expm(a * size * part) @ state
            axes = in_turning_axes(model, rest.configuration)
            moved = advance(model, rest.configuration, axes @ (position @ state))
            return rest._replace(
                configuration=moved,
                velocity=in_turning_axes(model, moved) @ (velocity @ state),
            )
        state = after
    return None


def _check_unchanged(
    changes: MotionChanges, small: SmallMotions, other: SmallMotions, turned: CompiledStart
) -> None:
    """ModelError for matrices that depend on the rotation of the bodies, or on their speed.

    The matrices of a drive train depend on neither, so a drive train may rotate by any angle.
    """
    k = changes.position.shape[1] - changes.control.shape[0] - changes.inputs.shape[0]
    shapes = changes.position[:, : k // 2]
    axes = in_turning_axes(turned.model, turned.configuration)
    rates = axes.T @ turned.velocity
    speed = max(float(np.linalg.norm(rates[part.start + 3 : part.start + 6])) for part in turned.model.slices)
    for name, power in (("position", 2), ("velocity", 1)):
        one, two = (np.asarray(getattr(each.residual, name)) @ shapes for each in (small, other))
        force, forced = shapes.T @ one, shapes.T @ two
        allowed = _CHANGED * speed**power + _ROUNDING * np.abs(force).max(initial=0.0)
        read, seen = (np.asarray(getattr(each.outputs, name)) @ shapes for each in (small, other))
        size = np.maximum(np.abs(read), np.abs(seen))
        shown = _CHANGED * size.max(axis=1, keepdims=True) + _ROUNDING * size.max(initial=0.0)
        if (np.abs(forced - force) > allowed).any() or (np.abs(seen - read) > shown).any():
            raise ModelError(
                "a body rotates by more than one radian within the run, due to its speed at the start, and "
                "equations or outputs of the machine change with this rotation or its speed, while the "
                "matrices of a linear machine are constant: start at rest (no velocities, no [spin]), or "
                "export the nonlinear machine"
            )


def _apart(rest: CompiledStart, begun: CompiledStart) -> Array:
    """Small motion (n,) from the equilibrium to the start, in the axes of the bodies."""
    model, one, other = rest.model, rest.configuration, begun.configuration
    found = np.zeros(model.n_velocities)
    pairs = zip(model.slices, model.coordinate_slices, strict=True)
    for body, (part, own) in enumerate(pairs):
        turn = np.asarray(one.rotations[body])
        found[part.start : part.start + 3] = turn.T @ (other.origins[body] - one.origins[body])
        found[part.start + 3 : part.start + 6] = np.asarray(rotation_log(turn.T @ other.rotations[body]))
        found[part.start + 6 : part.stop] = other.coordinates[own] - one.coordinates[own]
    return found


def _check(system: System, inputs: Mapping[str, Driven]) -> None:
    """ModelError for machines that have no linear form, with the cause and the remedy."""
    for placed in system.bodies:
        if placed.body.kind not in ("rigid", "reduced"):
            raise ModelError(
                f"'{placed.body.name}' is {placed.body.kind}, and a linear machine has rigid and reduced "
                "bodies only: reduce it, or export the nonlinear machine"
            )
    for load in system.acting:
        if hasattr(load, "penalty") or isinstance(load, JointFriction | RevoluteFriction | PrismaticFriction):
            raise ModelError(
                f"{load.label}: stops, contacts and friction have no linear form; leave it out, or export "
                "the nonlinear machine"
            )
    for name, element in inputs.items():
        if any(element is joint for joint in system.joints):
            raise ModelError(
                f"the prescribed motion of '{name}' cannot be an input of a linear machine, because the "
                "equations would contain its rates: drive a free joint by a servo, and make its set-point "
                "the input"
            )
