"""A machine as a function that advances it in time, with inputs and outputs, for use in other programs."""

from supple.stepping.step_program import StepProgram, StepState, step_program
from supple.stepping.variables import Variable

__all__ = ["StepProgram", "StepState", "Variable", "step_program"]
