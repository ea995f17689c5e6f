"""A machine as a program of one step, with inputs and outputs: what runs inside other programs."""

from supple.stepping.step_program import StepProgram, StepState, step_program
from supple.stepping.variables import Variable

__all__ = ["StepProgram", "StepState", "Variable", "step_program"]
