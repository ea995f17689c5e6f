"""Time integration of a machine from one time to the next, with inputs and outputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import AnyArray, Tree
from supple.equations.compiled_machine import compiled_start
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import SystemMotion
from supple.equations.machine_model import Model
from supple.errors import ModelError
from supple.integrate import ExplicitRule, Kinematic, Run
from supple.machine import SampledController, System
from supple.methods.floating.compiled.state import State
from supple.methods.intrinsic.supported_root import is_joined
from supple.quantities import Quantity
from supple.stepping.consistent_accelerations import after_jump, consistent_accelerations
from supple.stepping.external_inputs import Driven, ExternalInputs, external_inputs
from supple.stepping.floating_steps import FloatingSteps, floating_steps
from supple.stepping.joined_steps import JoinedSteps, SteppedState, joined_steps
from supple.stepping.parameters import AffineArrays, MachineParameters, affine_arrays
from supple.stepping.sensed_machine import SensedMachine, ends_on_lines
from supple.stepping.sensed_outputs import Contacts, SensedOutputs, contacts_of, sensed_outputs
from supple.stepping.variables import Variable, check_names
from supple.units import UNNAMED, UnitSystem


class StepState(NamedTuple):
    """The complete state of a machine between two steps, a pytree."""

    parameter: AnyArray
    """Parameters (k,)"""
    input: AnyArray
    """Inputs (i,) of the next step"""
    output: AnyArray
    """Outputs (o,)"""
    touching: AnyArray
    """Mask (c,): True for stops and contacts that are closed"""
    state: State | SteppedState
    held: AnyArray
    """Inputs (i,) for which the accelerations of the state hold"""


class _Parts(NamedTuple):
    """Data that may depend on the parameters; for a machine with parameters, also the initial state."""

    arrays: Tree
    reads: Tree
    """Functions that compute the outputs"""
    contacts: Contacts
    configuration: Tree = None
    velocity: AnyArray = None
    control: Tree = None


_SAME = 1e-9
"""Allowed difference between the output from affine arrays and that from arrays built from other values,
relative to 1 + |output|."""


@dataclass(frozen=True, eq=False)
class StepProgram:
    """A machine as a function from the state at one time to the state at a later time.

    march : the time integration
    parts : data of equations and outputs, as affine functions of the parameters
    parameters : numbers that can be changed
    start : the state at the start of the run
    duration : duration of the run
    """

    march: FloatingSteps | JoinedSteps
    parts: AffineArrays
    parameters: tuple[Variable, ...]
    inputs: ExternalInputs
    outputs: SensedOutputs
    start: StepState
    duration: float

    @property
    def size(self) -> float:
        """Time step, in the unit of time."""
        return self.march.size

    @property
    def n_equations(self) -> int:
        """Number of independent joint equations."""
        return len(self.march.model(self.parts.base.arrays).active)

    @cached_property
    def fixed_parameters(self) -> frozenset[int]:
        """Indices of the parameters on which the start depends; these can be set only before the start."""
        return frozenset(
            self.parts.depend(lambda parts: (parts.configuration, parts.velocity, parts.control))
        )

    def started(self, parameter: AnyArray, given: AnyArray) -> StepState:
        """The state at the start of the run for parameters (k,) and inputs (i,).

        Only for a machine with parameters. `failed` is True if the iteration of friction and joint forces
        does not converge.
        """
        parts = self.parts.at(parameter)
        model = self.inputs.given(parts.arrays, given)
        begun: Tree = self.start.state
        acceleration, multipliers, jams = consistent_accelerations(
            model, begun.time, parts.configuration, parts.velocity, parts.control
        )
        state = begun._replace(
            configuration=parts.configuration,
            velocity=parts.velocity,
            acceleration=acceleration,
            auxiliary=acceleration,
            multipliers=multipliers,
            control=parts.control,
            failed=jams,
        )
        motion = self.march.motion(model, state)
        before = jnp.zeros(len(self.outputs.variables))
        outputs = replace(self.outputs, reads=self.inputs.given(parts.reads, given))
        output = outputs.at(model, motion, before, 0.0)
        return StepState(parameter, given, output, parts.contacts.at(motion), state, given)

    def advanced(self, now: StepState, end: AnyArray) -> StepState:
        """The state at `end`, by equal steps of at most `size`; if a step fails, the state before that step.

        JAX can trace and compile this function. Forward-mode derivatives (`jax.jvp`, `jax.jacfwd`) with
        respect to inputs and state are those of the time-discrete motion.
        """
        parts = self.parts.at(now.parameter)
        arrays = self.inputs.given(parts.arrays, now.input)
        last: Tree = now.state
        jumps = self.inputs.jump and isinstance(self.march, FloatingSteps)
        begun: Tree = after_jump(self.inputs, parts.arrays, last, now.held, now.input) if jumps else last
        state: Tree = self.march.reached(arrays, begun, end)
        motion = self.march.motion(arrays, state)
        outputs = replace(self.outputs, reads=self.inputs.given(parts.reads, now.input))
        elapsed = state.time - now.state.time
        return now._replace(
            output=outputs.at(self.march.model(arrays), motion, now.output, elapsed),
            touching=parts.contacts.at(motion),
            state=state,
            held=now.input,
        )

    @cached_property
    def compiled(self) -> Callable[[StepState, float], StepState]:
        """`advanced` as a compiled function (state, time) -> state."""
        program = jax.jit(self.advanced).lower(self.start, np.float64(0.0)).compile(STARTING)
        return lambda now, end: program(now, np.float64(end))


@checked_arguments
def step_program(
    system: System,
    run: Run,
    sensors: Sequence[Quantity] = (),
    inputs: Mapping[str, Driven] = MappingProxyType({}),
    *,
    input_units: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
    parameters: MachineParameters | None = None,
) -> StepProgram:
    """The time integration of a machine of rigid, reduced and intrinsic bodies, from one time to the next.

    Parameters
    ----------
    run : Run       start, steps and tolerances
    sensors : sensors whose channels are the outputs; `outputs.left_out` of the result names the sensors that
        JAX cannot trace
    inputs : joints and loads of the machine whose laws become inputs, by the name of the input
    input_units : units of the inputs,  units : units of the sensors
    parameters : numbers that can be changed before the start, or between two steps

    Raises ModelError for other kinds of bodies, intrinsic bodies with a supported root, a kinematic or
    explicit method, sampled controllers, a machine without outputs, parameters beside intrinsic bodies, and
    as `affine_arrays`.
    """
    own = () if parameters is None else parameters.variables
    _check(system, run, inputs, own)
    external = external_inputs(system, inputs, input_units, run.start)
    sensors = external.sensors(sensors)
    march, arrays, state, seen = _made_ready(external.system, run, sensors)
    external.check_read(arrays)
    sensed = sensed_outputs(seen, sensors, units)
    check_names((*own, *external.variables), sensed.variables)
    parts = AffineArrays(_Parts(arrays, sensed.reads, contacts_of(seen.system)), np.zeros(0), {})
    motion = march.motion(external.given(arrays, external.start), state)
    first = _read(sensed, march.model(arrays), motion)
    named = tuple(
        replace(variable, start=float(value)) for variable, value in zip(sensed.variables, first, strict=True)
    )
    if parameters is not None and own:
        parts = _by_parameters(parameters, run.start, sensed)
    return StepProgram(
        march=march,
        parts=parts,
        parameters=own,
        inputs=external,
        outputs=replace(sensed, variables=named),
        start=StepState(
            parts.start,
            external.start,
            first,
            np.asarray(parts.base.contacts.at(motion)),
            state,
            external.start,
        ),
        duration=float(run.duration),
    )


def _read(sensed: SensedOutputs, model: Model, motion: SystemMotion) -> np.ndarray:
    given = motion, np.zeros(len(sensed.variables))
    program = jax.jit(lambda now, before: sensed.at(model, now, before, 0.0)).lower(*given)
    return np.asarray(program.compile(STARTING)(*given))


def _by_parameters(parameters: MachineParameters, time: float, sensed: SensedOutputs) -> AffineArrays:
    """The parts of a machine of rigid and reduced bodies as affine functions of its parameters.

    Raises ModelError if a parameter changes how outputs are computed, and as `affine_arrays`.
    """
    made: list[tuple[np.ndarray, _Parts, SensedOutputs]] = []

    def variant(values: np.ndarray) -> _Parts:
        system, sensors, inputs = parameters.machine(values)
        external = external_inputs(system, inputs, {}, time)
        start = compiled_start(external.system, time)
        seen = SensedMachine(external.system, external.system)
        outputs = sensed_outputs(seen, external.sensors(sensors), UNNAMED)
        outputs = replace(outputs, reads=external.unset(outputs.reads))
        model = external.unset(_without_unread_scales(start.model))
        at = start.configuration, start.velocity, start.control
        parts = _Parts(model, outputs.reads, contacts_of(external.system), *at)
        made.append((values, parts, outputs))
        return parts

    found = affine_arrays(variant, parameters)
    values, parts, outputs = made[-1]
    draw = np.random.default_rng(0).normal
    velocity = parts.velocity + draw(size=parts.velocity.shape)
    acceleration, multipliers = draw(size=velocity.shape), draw(size=len(parts.arrays.active))
    motion = SystemMotion(np.asarray(time), parts.configuration, velocity, acceleration, multipliers)
    ours = found.at(values)
    expected = _read(outputs, parts.arrays, motion)
    actual = _read(replace(sensed, reads=ours.reads), ours.arrays, motion)
    wrong = np.abs(actual - expected) > _SAME * (1.0 + np.abs(expected))
    if wrong.any():
        name = sensed.variables[int(np.argmax(wrong))].name
        raise ModelError(
            f"a parameter changes where or how the output '{name}' is read: remove that output or the "
            "parameter, or export one machine for each value"
        )
    return found


def _without_unread_scales(model: Model) -> Model:
    """The model without the unused coordinate scales of rigid bodies, which are nonlinear in the mass."""
    groups = (
        group if group.r else replace(group, coordinate_scale=np.zeros(len(group.members)))
        for group in model.groups
    )
    return replace(model, groups=tuple(groups))


def _made_ready(
    system: System, run: Run, sensors: Sequence[Quantity]
) -> tuple[FloatingSteps | JoinedSteps, Tree, Tree, SensedMachine]:
    """Time integration of a machine, its arrays, the initial state, and the machine for its sensors."""
    if any(placed.body.kind == "intrinsic" for placed in system.bodies):
        joined, machine, begun = joined_steps(system, run, ends_on_lines(system, sensors))
        return joined, machine.arrays, begun, SensedMachine(system, machine.seen)
    return *floating_steps(system, run), SensedMachine(system, system)


_OTHERS = {
    "full": "full bodies are stepped by sparse factors, and a step program has arrays of fixed size: reduce "
    "them",
    "explicit": "explicit elements are stepped node by node, with steps that depend on their deformation: "
    "reduce the body, or make it rigid",
    "modal": "modal subdomains are stepped together with the explicit parts that they are tied to: reduce "
    "the body",
}
"""Reason and remedy for kinds of bodies that a step program does not support."""


def _check(system: System, run: Run, inputs: Mapping[str, Driven], parameters: Sequence[Variable]) -> None:
    """ModelError for machines that have no step program, with the cause and the remedy."""
    kinds = {placed.body.kind for placed in system.bodies}
    for kind in sorted(kinds - {"rigid", "reduced", "intrinsic"}):
        names = ", ".join(f"'{placed.body.name}'" for placed in system.bodies if placed.body.kind == kind)
        raise ModelError(f"{names}: {_OTHERS.get(kind, f'{kind} bodies are stepped in Python: reduce them')}")
    if isinstance(run.method, Kinematic | ExplicitRule):
        raise ModelError(
            f"a run by {type(run.method).__name__} has no step program: use GeneralizedAlpha(rho_inf), or "
            "omit the method"
        )
    if any(isinstance(each, SampledController) for each in system.controllers):
        raise ModelError(
            "a sampled controller runs Python, and a step program cannot: remove it, and make the elements "
            "that it drives inputs"
        )
    if "intrinsic" in kinds:
        if parameters:
            raise ModelError(
                "a machine with intrinsic bodies has no parameters: export one machine for each value"
            )
        _check_lines(system, inputs)


def _check_lines(system: System, inputs: Mapping[str, Driven]) -> None:
    """ModelError for intrinsic bodies with a supported root, and for a prescribed motion as an input."""
    if not is_joined(system):
        raise ModelError(
            "intrinsic bodies with a supported root have no step program: place released(body), which has a "
            "free root for joints, and use GeneralizedAlpha"
        )
    for name, element in inputs.items():
        if any(element is joint for joint in system.joints):
            raise ModelError(
                f"the prescribed motion of '{name}' cannot be an input beside intrinsic bodies, whose "
                "equations contain its rate: drive a free joint by a servo, and make its set-point the input"
            )
