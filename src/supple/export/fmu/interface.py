"""The data of a machine that the description of an FMU contains: variables, and times of the run."""

from __future__ import annotations

from dataclasses import dataclass

from supple.export.linear.linear_form import LinearForm
from supple.stepping import StepProgram
from supple.stepping.variables import Variable

__all__ = ["FmuInterface"]


@dataclass(frozen=True)
class FmuInterface:
    """Variables and run times of a machine, for the importer of an FMU.

    fixed_parameters : indices of the parameters that can be set before the start only
    time, size, duration : start time, time step and duration of the run of the case
    has_contacts : whether there are stops or contacts, which cause events
    """

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    time: float
    size: float
    duration: float
    parameters: tuple[Variable, ...] = ()
    fixed_parameters: frozenset[int] = frozenset()
    has_contacts: bool = False

    @classmethod
    def of_steps(cls, step: StepProgram) -> FmuInterface:
        """The interface of a nonlinear machine, which is integrated in time steps."""
        return cls(
            step.inputs.variables,
            step.outputs.variables,
            float(step.start.state.time),
            step.size,
            step.duration,
            step.parameters,
            step.fixed_parameters,
            bool(len(step.start.touching)),
        )

    @classmethod
    def of_linear(cls, form: LinearForm) -> FmuInterface:
        """The interface of a linear machine."""
        return cls(form.inputs, form.outputs, form.time, form.size, form.duration)
