"""The march of a machine from one instant to the next, with inputs and outputs: what is printed as C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.compiled_machine import compiled_start
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration, ControlState, SystemMotion
from supple.equations.model import Model
from supple.errors import ModelError
from supple.export.c.consistent_accelerations import consistent_accelerations
from supple.export.c.contacts import Contacts, contacts_of
from supple.export.c.external_inputs import ExternalInputs, external_inputs
from supple.export.c.parameters import AffineArrays, MachineParameters, affine_arrays
from supple.export.c.sensed_outputs import SensedOutputs, sensed_outputs
from supple.export.c.variables import Variable
from supple.integrate import Kinematic, Run
from supple.machine import SampledController, System
from supple.methods.floating.compiled.elimination import ByLapack
from supple.methods.floating.compiled.engine import controls, initial_state
from supple.methods.floating.compiled.padded_motion import with_padding_coordinates
from supple.methods.floating.compiled.state import Controls, State
from supple.methods.floating.compiled.time_step import substep
from supple.quantities import Quantity
from supple.units import UNNAMED, UnitSystem

__all__ = ["Instant", "MachineStep", "machine_step"]


class Instant(NamedTuple):
    """All that a machine is between two steps."""

    parameter: Any
    """(k,)"""
    input: Any
    """(i,) as they act from here on"""
    output: Any
    """(o,)"""
    touching: Any
    """(c,) whether stops and contacts touch"""
    state: State


_SAME = 1e-9
"""What outputs may differ by between a machine made anew and its parameters changed."""


@dataclass(frozen=True, eq=False)
class MachineStep:
    """A machine made ready to be stepped by others.

    size : of its steps, in the unit of time
    duration : of the run of its case
    """

    settings: Controls
    parts: AffineArrays
    """`_Parts` of the machine by its parameters"""
    parameters: tuple[Variable, ...]
    inputs: ExternalInputs
    outputs: SensedOutputs
    start: Instant
    size: float
    duration: float

    @property
    def model(self) -> Model:
        """As the case has it."""
        return self.parts.base.model

    @cached_property
    def fixed_parameters(self) -> frozenset[int]:
        """Numbers of the parameters on which the start depends: they are set before it."""
        return frozenset(
            self.parts.depend(lambda parts: (parts.configuration, parts.velocity, parts.control))
        )

    def started(self, parameter: Any, given: Any) -> Instant:
        """The machine at the start of its run, with parameters (k,) and inputs (i,)."""
        parts = self.parts.at(parameter)
        model = self.inputs.given(parts.model, given)
        time = self.start.state.time
        acceleration, multipliers, jams = consistent_accelerations(
            model, time, parts.configuration, parts.velocity, parts.control
        )
        state = self.start.state._replace(
            configuration=parts.configuration,
            velocity=parts.velocity,
            acceleration=acceleration,
            auxiliary=acceleration,
            multipliers=multipliers,
            control=parts.control,
            failed=jams,
        )
        before = jnp.zeros(len(self.outputs.variables))
        output = replace(self.outputs, reads=parts.reads).at(model, _motion(state), before, 0.0)
        return Instant(parameter, given, output, parts.contacts.at(_motion(state)), state)

    def advanced(self, now: Instant, end: Any) -> Instant:
        """The machine at a time, in as many steps as the march takes; after a failure, before that step."""
        parts = self.parts.at(now.parameter)
        model = self.inputs.given(parts.model, now.input)
        state = jax.lax.while_loop(
            lambda s: (s.time < end) & ~s.failed,
            partial(substep, ByLapack(), model, self.settings, end),
            now.state,
        )
        elapsed = state.time - now.state.time
        outputs = replace(self.outputs, reads=parts.reads)
        return now._replace(
            output=outputs.at(model, _motion(state), now.output, elapsed),
            touching=parts.contacts.at(_motion(state)),
            state=state,
        )

    @cached_property
    def compiled(self) -> Any:
        """The same, compiled by JAX."""
        program = jax.jit(self.advanced).lower(self.start, np.float64(0.0)).compile(STARTING)
        return lambda now, end: program(now, np.float64(end))


def _motion(state: State) -> SystemMotion:
    return SystemMotion(
        state.time, state.configuration, state.velocity, state.acceleration, state.multipliers
    )


class _Parts(NamedTuple):
    """What depends on the parameters."""

    model: Model
    configuration: Configuration
    velocity: Any
    control: ControlState | None
    reads: Any
    """Of the outputs"""
    contacts: Contacts


def machine_step(
    system: System,
    run: Run,
    sensors: Sequence[Quantity] = (),
    inputs: Mapping[str, Any] = MappingProxyType({}),
    *,
    input_units: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
    parameters: MachineParameters | None = None,
) -> MachineStep:
    """The compiled march of a machine of rigid and reduced bodies, ready to be printed.

    sensors : what it gives
    inputs : by name, joints and loads of the machine whose laws are given from outside
    input_units : of these;   units : of the sensors
    parameters : numbers of the machine that may be changed before it starts, or between two steps

    Raises ModelError for other forms of bodies, other methods, and sampled controllers; as `affine_arrays`.
    """
    _check_exportable(system, run)
    external = external_inputs(with_padding_coordinates(system), inputs, input_units, run.start)
    model, state = initial_state(external.system, run.start, run.step_control.first, run.validity)
    state = jax.tree.map(np.asarray, state)
    sensed = sensed_outputs(external.system, sensors, units)
    own = () if parameters is None else parameters.variables
    _check_names((*own, *external.variables), sensed)
    contacts = contacts_of(external.system)
    base = _Parts(model, state.configuration, state.velocity, state.control, sensed.reads, contacts)
    parts = AffineArrays(base, np.zeros(0), {})
    if parameters is not None and own:
        parts = _by_parameters(parameters, run.start, sensed)
    first = _read(sensed, model, _motion(state))
    named = tuple(
        replace(variable, start=float(value)) for variable, value in zip(sensed.variables, first, strict=True)
    )
    return MachineStep(
        settings=controls(run),
        parts=parts,
        parameters=own,
        inputs=external,
        outputs=replace(sensed, variables=named),
        start=Instant(parts.start, external.start, first, np.asarray(contacts.at(_motion(state))), state),
        size=float(run.step_control.first),
        duration=float(run.duration),
    )


def _check_exportable(system: System, run: Run) -> None:
    kinds = sorted({placed.body.kind for placed in system.bodies} - {"rigid", "reduced"})
    if kinds or isinstance(run.method, Kinematic):
        what = f"bodies that are {', '.join(kinds)}" if kinds else "a kinematic run"
        raise ModelError(
            f"the compiled march of rigid and reduced bodies is exported, not {what}: reduce them"
        )
    if any(isinstance(each, SampledController) for each in system.controllers):
        raise ModelError(
            "a sampled controller runs Python, which an exported machine has not: leave it out and make the "
            "elements it drives inputs"
        )


def _check_names(given: Sequence[Variable], sensed: SensedOutputs) -> None:
    if not sensed.variables:
        raise ModelError("the machine has no output: name sensors, or places to track, that it shall give")
    names = [variable.name for variable in (*given, *sensed.variables)]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(
                f"two parameters, inputs or outputs would be named '{name}': give them other names"
            )


def _read(sensed: SensedOutputs, model: Model, motion: SystemMotion) -> np.ndarray:
    before = np.zeros(len(sensed.variables))
    return np.asarray(jax.jit(lambda now, last: sensed.at(model, now, last, 0.0))(motion, before))


def _by_parameters(parameters: MachineParameters, time: float, sensed: SensedOutputs) -> AffineArrays:
    """The parts of the machine as functions of its parameters; the outputs are compared as well."""
    made: list[tuple[np.ndarray, _Parts, SensedOutputs]] = []

    def variant(values: np.ndarray) -> _Parts:
        system, sensors, inputs = parameters.machine(values)
        external = external_inputs(with_padding_coordinates(system), inputs, {}, time)
        start = compiled_start(external.system, time)
        outputs = sensed_outputs(external.system, sensors, UNNAMED)
        model = external.unset(_without_unread_scales(start.model))
        at = start.configuration, start.velocity, start.control
        parts = _Parts(model, *at, outputs.reads, contacts_of(external.system))
        made.append((values, parts, outputs))
        return parts

    found = affine_arrays(variant, parameters)
    values, parts, outputs = made[-1]
    draw = np.random.default_rng(0).normal
    velocity = parts.velocity + draw(size=parts.velocity.shape)
    acceleration, multipliers = draw(size=velocity.shape), draw(size=len(parts.model.active))
    motion = SystemMotion(np.asarray(time), parts.configuration, velocity, acceleration, multipliers)
    ours = found.at(values)
    expected = _read(outputs, parts.model, motion)
    actual = _read(replace(sensed, reads=ours.reads), ours.model, motion)
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
