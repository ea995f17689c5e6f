"""The march of a machine from one instant to the next, with inputs and outputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import checked_arguments
from supple.equations.compiled_machine import compiled_start
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import SystemMotion
from supple.equations.machine_model import Model
from supple.errors import ModelError
from supple.integrate import ExplicitRule, Kinematic, Run
from supple.machine import SampledController, System
from supple.methods.intrinsic.supported_root import is_joined
from supple.quantities import Quantity
from supple.stepping.consistent_accelerations import consistent_accelerations
from supple.stepping.contacts import Contacts, contacts_of
from supple.stepping.external_inputs import ExternalInputs, external_inputs
from supple.stepping.floating_steps import floating_steps
from supple.stepping.joined_steps import joined_steps
from supple.stepping.marching import Marching, MarchingState
from supple.stepping.parameters import AffineArrays, MachineParameters, affine_arrays
from supple.stepping.sensed_machine import SensedMachine, ends_on_lines
from supple.stepping.sensed_outputs import SensedOutputs, sensed_outputs
from supple.stepping.variables import Variable
from supple.units import UNNAMED, UnitSystem

__all__ = ["StepProgram", "StepState", "step_program"]


class StepState(NamedTuple):
    """All that a machine is between two steps, a pytree."""

    parameter: Any
    """(k,)"""
    input: Any
    """(i,) as they act from here on"""
    output: Any
    """(o,)"""
    touching: Any
    """(c,) whether stops and contacts touch"""
    state: MarchingState


class _Parts(NamedTuple):
    """What depends on the parameters; the state at the start of machines that have some."""

    arrays: Any
    reads: Any
    """Of the outputs"""
    contacts: Contacts
    configuration: Any = None
    velocity: Any = None
    control: Any = None


_SAME = 1e-9
"""Largest difference of outputs between a machine made anew and its parameters changed."""


@dataclass(frozen=True, eq=False)
class StepProgram:
    """A machine as a function from one instant to the next.

    march : how its method steps
    parts : the numbers of its equations and outputs by its parameters
    parameters : numbers that may be changed
    start : at the start of its run
    duration : of its run
    """

    march: Marching
    parts: AffineArrays
    parameters: tuple[Variable, ...]
    inputs: ExternalInputs
    outputs: SensedOutputs
    start: StepState
    duration: float

    @property
    def size(self) -> float:
        """Of its steps, in the unit of time."""
        return self.march.size

    @property
    def n_equations(self) -> int:
        """Number of independent equations of its joints."""
        return len(self.march.model(self.parts.base.arrays).active)

    @cached_property
    def fixed_parameters(self) -> frozenset[int]:
        """Numbers of the parameters on which the start depends: they are set before it."""
        return frozenset(
            self.parts.depend(lambda parts: (parts.configuration, parts.velocity, parts.control))
        )

    def started(self, parameter: Any, given: Any) -> StepState:
        """The machine at the start of its run, with parameters (k,) and inputs (i,)."""
        parts = self.parts.at(parameter)
        model = self.inputs.given(parts.arrays, given)
        begun: Any = self.start.state
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
        output = replace(self.outputs, reads=parts.reads).at(model, motion, before, 0.0)
        return StepState(parameter, given, output, parts.contacts.at(motion), state)

    def advanced(self, now: StepState, end: Any) -> StepState:
        """The machine at a time, by equal steps of `size` at most; after a failure, before that step.

        JAX traces and compiles it. Its derivatives in forward mode (`jax.jvp`, `jax.jacfwd`), for inputs and
        state, are those of the discrete motion.
        """
        parts = self.parts.at(now.parameter)
        arrays = self.inputs.given(parts.arrays, now.input)
        state = self.march.reached(arrays, now.state, end)
        motion = self.march.motion(arrays, state)
        outputs = replace(self.outputs, reads=parts.reads)
        elapsed = state.time - now.state.time
        return now._replace(
            output=outputs.at(self.march.model(arrays), motion, now.output, elapsed),
            touching=parts.contacts.at(motion),
            state=state,
        )

    @cached_property
    def compiled(self) -> Any:
        """`advanced`, compiled: a function of an instant and a time."""
        program = jax.jit(self.advanced).lower(self.start, np.float64(0.0)).compile(STARTING)
        return lambda now, end: program(now, np.float64(end))


@checked_arguments
def step_program(
    system: System,
    run: Run,
    sensors: Sequence[Quantity] = (),
    inputs: Mapping[str, Any] = MappingProxyType({}),
    *,
    input_units: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
    parameters: MachineParameters | None = None,
) -> StepProgram:
    """The march of a machine of rigid, reduced and joined intrinsic bodies as a function of one step.

    Parameters
    ----------
    run : Run       start, steps and tolerances
    sensors : of the outputs, channel after channel; those without a traced form are in `outputs.left_out`
    inputs : by name, joints and loads of the machine whose laws are given from outside
    input_units : of these,  units : of the sensors
    parameters : numbers that may be changed before the start, or between two steps

    Raises ModelError for other forms of bodies, other methods, sampled controllers, a machine without any
    output, and as `affine_arrays`.
    """
    own = () if parameters is None else parameters.variables
    _check(system, run, inputs, own)
    external = external_inputs(system, inputs, input_units, run.start)
    march, arrays, state, seen = _made_ready(external.system, run, sensors)
    external.check_read(arrays)
    sensed = sensed_outputs(seen, sensors, units)
    _check_names((*own, *external.variables), sensed)
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
            parts.start, external.start, first, np.asarray(parts.base.contacts.at(motion)), state
        ),
        duration=float(run.duration),
    )


def _read(sensed: SensedOutputs, model: Model, motion: SystemMotion) -> np.ndarray:
    given = motion, np.zeros(len(sensed.variables))
    program = jax.jit(lambda now, before: sensed.at(model, now, before, 0.0)).lower(*given)
    return np.asarray(program.compile(STARTING)(*given))


def _by_parameters(parameters: MachineParameters, time: float, sensed: SensedOutputs) -> AffineArrays:
    """The parts of a machine of rigid and reduced bodies as functions of its parameters.

    Raises ModelError where outputs are read at other places, beside the errors of `affine_arrays`.
    """
    made: list[tuple[np.ndarray, _Parts, SensedOutputs]] = []

    def variant(values: np.ndarray) -> _Parts:
        system, sensors, inputs = parameters.machine(values)
        external = external_inputs(system, inputs, {}, time)
        start = compiled_start(external.system, time)
        outputs = sensed_outputs(SensedMachine(external.system, external.system), sensors, UNNAMED)
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
            f"a parameter changes where or how the output '{name}' is read: leave that output or the "
            "parameter out, or export one machine for each value"
        )
    return found


def _without_unread_scales(model: Model) -> Model:
    """Rigid bodies have no coordinates to scale; the scale is no linear function of their mass."""
    groups = (
        group if group.r else replace(group, coordinate_scale=np.zeros(len(group.members)))
        for group in model.groups
    )
    return replace(model, groups=tuple(groups))


def _made_ready(
    system: System, run: Run, sensors: Sequence[Quantity]
) -> tuple[Marching, Any, Any, SensedMachine]:
    """How a machine is stepped, its arrays, the state in which its run starts, and what sensors see of it."""
    if any(placed.body.kind == "intrinsic" for placed in system.bodies):
        joined, machine, begun = joined_steps(system, run, ends_on_lines(system, sensors))
        return joined, machine.arrays, begun, SensedMachine(system, machine.seen)
    return *floating_steps(system, run), SensedMachine(system, system)


_OTHERS = {
    "full": "full bodies are stepped by sparse factors, which no program of fixed arrays holds: reduce them",
    "explicit": "explicit elements are stepped node by node, by steps that follow their deformation: reduce "
    "the body, or make it rigid",
    "modal": "modal subdomains are stepped with the explicit parts that they are tied to: reduce the body",
}


def _check(system: System, run: Run, inputs: Mapping[str, Any], parameters: Sequence[Variable]) -> None:
    """ModelError for machines that have no step program, with the cause and the remedy."""
    kinds = {placed.body.kind for placed in system.bodies}
    for kind in sorted(kinds - {"rigid", "reduced", "intrinsic"}):
        names = ", ".join(f"'{placed.body.name}'" for placed in system.bodies if placed.body.kind == kind)
        raise ModelError(f"{names}: {_OTHERS.get(kind, f'{kind} bodies are stepped in Python: reduce them')}")
    if isinstance(run.method, Kinematic | ExplicitRule):
        raise ModelError(
            f"a run by {type(run.method).__name__} has no step program: give GeneralizedAlpha(rho_inf), "
            "or no method"
        )
    if any(isinstance(each, SampledController) for each in system.controllers):
        raise ModelError(
            "a sampled controller runs Python, which a step program has not: leave it out and make the "
            "elements it drives inputs"
        )
    if "intrinsic" in kinds:
        if parameters:
            raise ModelError(
                "a machine with intrinsic bodies has no parameters: export one machine for each value"
            )
        _check_lines(system, inputs)


def _check_lines(system: System, inputs: Mapping[str, Any]) -> None:
    """ModelError for lines whose modes hold their roots, and for a prescribed motion as an input."""
    if not is_joined(system):
        raise ModelError(
            "intrinsic bodies whose modes hold their roots have no step program: place released(body), which "
            "any joint may hold, with GeneralizedAlpha"
        )
    for name, element in inputs.items():
        if any(element is joint for joint in system.joints):
            raise ModelError(
                f"the prescribed motion of '{name}' cannot be an input beside intrinsic bodies, whose "
                "equations contain its rate: let a servo turn a free joint, and make its set-point the input"
            )


def _check_names(given: Sequence[Variable], outputs: SensedOutputs) -> None:
    """ModelError where there is no output, or two variables of one name."""
    if not outputs.variables:
        raise ModelError("the machine has no output: name sensors, or places to track, that it shall give")
    names = [variable.name for variable in (*given, *outputs.variables)]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(
                f"two parameters, inputs or outputs would be named '{name}': give them other names"
            )
