"""The march of a machine from one instant to the next, with inputs and outputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import jax
import numpy as np

from supple.arguments import checked_arguments
from supple.equations.compiler_options import STARTING
from supple.errors import ModelError
from supple.integrate import ExplicitRule, Kinematic, Run
from supple.machine import SampledController, System
from supple.methods.intrinsic.supported_root import is_joined
from supple.quantities import Quantity
from supple.stepping.external_inputs import ExternalInputs, external_inputs
from supple.stepping.floating_steps import floating_steps
from supple.stepping.joined_steps import joined_steps
from supple.stepping.marching import Marching, MarchingState
from supple.stepping.seen_machine import SeenMachine, ends_on_lines
from supple.stepping.sensed_outputs import SensedOutputs, sensed_outputs
from supple.units import UNNAMED, UnitSystem

__all__ = ["Instant", "StepProgram", "step_program"]


class Instant(NamedTuple):
    """All that a machine is between two steps, a pytree."""

    input: Any
    """(i,) as they act from here on"""
    output: Any
    """(o,)"""
    state: MarchingState


@dataclass(frozen=True, eq=False)
class StepProgram:
    """A machine as a function from one instant to the next.

    march : how its method steps
    arrays : the numbers of its equations
    start : at the start of its run
    duration : of its run
    """

    march: Marching
    arrays: Any
    inputs: ExternalInputs
    outputs: SensedOutputs
    start: Instant
    duration: float

    @property
    def size(self) -> float:
        """Of its steps, in the unit of time."""
        return self.march.size

    @property
    def n_equations(self) -> int:
        """Number of independent equations of its joints."""
        return len(self.march.model(self.arrays).active)

    def advanced(self, now: Instant, end: Any) -> Instant:
        """The machine at a time, by equal steps of `size` at most; after a failure, before that step.

        JAX traces and compiles it. Its derivatives in forward mode (`jax.jvp`, `jax.jacfwd`), for inputs and
        state, are those of the discrete motion.
        """
        arrays = self.inputs.given(self.arrays, now.input)
        state = self.march.reached(arrays, now.state, end)
        elapsed = state.time - now.state.time
        output = self.outputs.at(
            self.march.model(arrays), self.march.motion(arrays, state), now.output, elapsed
        )
        return Instant(now.input, output, state)

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
) -> StepProgram:
    """The march of a machine of rigid, reduced and joined intrinsic bodies as a function of one step.

    Parameters
    ----------
    run : Run       start, steps and tolerances
    sensors : of the outputs, channel after channel; those without a traced form are in `outputs.left_out`
    inputs : by name, joints and loads of the machine whose laws are given from outside
    input_units : of these,  units : of the sensors

    Raises ModelError for other forms of bodies, other methods, sampled controllers, and a machine without any
    output.
    """
    _check(system, run, inputs)
    external = external_inputs(system, inputs, input_units, run.start)
    march, arrays, state, seen = _made_ready(external.system, run, sensors)
    external.check_read(arrays)
    sensed = sensed_outputs(seen, sensors, units)
    _check_names(external, sensed)
    begin = state, np.zeros(len(sensed.variables))
    first = np.asarray(
        jax.jit(lambda now, before: sensed.at(march.model(arrays), march.motion(arrays, now), before, 0.0))
        .lower(*begin)
        .compile(STARTING)(*begin)
    )
    named = tuple(
        replace(variable, start=float(value)) for variable, value in zip(sensed.variables, first, strict=True)
    )
    return StepProgram(
        march=march,
        arrays=arrays,
        inputs=external,
        outputs=replace(sensed, variables=named),
        start=Instant(external.start, first, state),
        duration=float(run.duration),
    )


def _made_ready(
    system: System, run: Run, sensors: Sequence[Quantity]
) -> tuple[Marching, Any, Any, SeenMachine]:
    """How a machine is stepped, its arrays, the state in which its run starts, and what sensors see of it."""
    if any(placed.body.kind == "intrinsic" for placed in system.bodies):
        joined, machine, begun = joined_steps(system, run, ends_on_lines(system, sensors))
        return joined, machine.arrays, begun, SeenMachine(system, machine.seen)
    return *floating_steps(system, run), SeenMachine(system, system)


_OTHERS = {
    "full": "full bodies are stepped by sparse factors, which no program of fixed arrays holds: reduce them",
    "explicit": "explicit elements are stepped node by node, by steps that follow their deformation: reduce "
    "the body, or make it rigid",
    "modal": "modal subdomains are stepped with the explicit parts that they are tied to: reduce the body",
}


def _check(system: System, run: Run, inputs: Mapping[str, Any]) -> None:
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


def _check_names(inputs: ExternalInputs, outputs: SensedOutputs) -> None:
    """ModelError where there is no output, or two variables of one name."""
    if not outputs.variables:
        raise ModelError("the machine has no output: name sensors, or places to track, that it shall give")
    names = [variable.name for variable in (*inputs.variables, *outputs.variables)]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(f"two inputs or outputs would be named '{name}': give the sensors other names")
