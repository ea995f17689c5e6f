"""The step program of a machine under the names that the printers use."""

from supple.stepping import Instant
from supple.stepping import StepProgram as MachineStep
from supple.stepping import step_program as machine_step

__all__ = ["Instant", "MachineStep", "machine_step"]
