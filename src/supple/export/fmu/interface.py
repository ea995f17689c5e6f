"""What the description of an FMU states of a machine: its variables, and the time of its run."""

from __future__ import annotations

from dataclasses import dataclass

from supple.export.linear.linear_form import LinearForm
from supple.stepping import StepProgram
from supple.stepping.variables import Variable

__all__ = ["Interface"]


@dataclass(frozen=True)
class Interface:
    """A machine as an importer sees it.

    fixed_parameters : numbers of the parameters that are set before the start
    time, size, duration : start, step and length of the run of its case
    has_contacts : whether it has stops or contacts, which make events
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
    def of_steps(cls, step: StepProgram) -> Interface:
        """Of a machine that marches."""
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
    def of_linear(cls, form: LinearForm) -> Interface:
        """Of a linear machine."""
        return cls(form.inputs, form.outputs, form.time, form.size, form.duration)
