"""Named inputs, outputs and parameters of a step program."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Variable"]


@dataclass(frozen=True)
class Variable:
    """One input, output or parameter of a machine.

    start : value at the start of the run
    """

    name: str
    unit: str
    description: str
    start: float = 0.0
