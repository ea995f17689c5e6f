"""Inputs and outputs of a step program by name."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Variable"]


@dataclass(frozen=True)
class Variable:
    """One number of the input or output of a machine.

    start : at the start of the run
    """

    name: str
    unit: str
    description: str
    start: float = 0.0
