"""Inputs and outputs of a step program under the name that the printers use."""

from supple.stepping import Variable

__all__ = ["Variable"]
