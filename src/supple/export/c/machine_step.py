"""The march of a machine from one instant to the next, with inputs and outputs: what is printed as C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any, NamedTuple

import jax
import numpy as np

from supple.equations.compiler_options import STARTING
from supple.equations.configuration import SystemMotion
from supple.equations.model import Model
from supple.errors import ModelError
from supple.export.c.external_inputs import ExternalInputs, external_inputs
from supple.export.c.sensed_outputs import SensedOutputs, sensed_outputs
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

    input: Any
    """(i,) as they act from here on"""
    output: Any
    """(o,)"""
    state: State


@dataclass(frozen=True, eq=False)
class MachineStep:
    """A machine made ready to be stepped by others.

    size : of its steps, in the unit of time
    duration : of the run of its case
    """

    model: Model
    settings: Controls
    inputs: ExternalInputs
    outputs: SensedOutputs
    start: Instant
    size: float
    duration: float

    def advanced(self, now: Instant, end: Any) -> Instant:
        """The machine at a time, in as many steps as the march takes; after a failure, before that step."""
        model = self.inputs.given(self.model, now.input)
        state = jax.lax.while_loop(
            lambda s: (s.time < end) & ~s.failed,
            partial(substep, ByLapack(), model, self.settings, end),
            now.state,
        )
        elapsed = state.time - now.state.time
        return Instant(now.input, self.outputs.at(model, _motion(state), now.output, elapsed), state)

    @cached_property
    def compiled(self) -> Any:
        """The same, compiled by JAX."""
        program = jax.jit(self.advanced).lower(self.start, np.float64(0.0)).compile(STARTING)
        return lambda now, end: program(now, np.float64(end))


def _motion(state: State) -> SystemMotion:
    return SystemMotion(
        state.time, state.configuration, state.velocity, state.acceleration, state.multipliers
    )


def machine_step(
    system: System,
    run: Run,
    sensors: Sequence[Quantity] = (),
    inputs: Mapping[str, Any] = MappingProxyType({}),
    *,
    input_units: Mapping[str, str] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> MachineStep:
    """The compiled march of a machine of rigid and reduced bodies, ready to be printed.

    sensors : what it gives
    inputs : by name, joints and loads of the machine whose laws are given from outside
    input_units : of these;   units : of the sensors

    Raises ModelError for other forms of bodies, other methods, and sampled controllers.
    """
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
    external = external_inputs(with_padding_coordinates(system), inputs, input_units, run.start)
    filled = external.system
    model, state = initial_state(filled, run.start, run.step_control.first, run.validity)
    state = jax.tree.map(np.asarray, state)
    sensed = sensed_outputs(filled, sensors, units)
    if not sensed.variables:
        raise ModelError("the machine has no output: name sensors, or places to track, that it shall give")
    names = [variable.name for variable in (*external.variables, *sensed.variables)]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(f"two inputs or outputs would be named '{name}': give the sensors other names")
    first = np.asarray(
        jax.jit(lambda now, before: sensed.at(model, _motion(now), before, 0.0))(
            state, np.zeros(len(sensed.variables))
        )
    )
    named = tuple(
        replace(variable, start=float(value)) for variable, value in zip(sensed.variables, first, strict=True)
    )
    return MachineStep(
        model=model,
        settings=controls(run),
        inputs=external,
        outputs=replace(sensed, variables=named),
        start=Instant(external.start, first, state),
        size=float(run.step_control.first),
        duration=float(run.duration),
    )
