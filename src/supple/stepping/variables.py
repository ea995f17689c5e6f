"""Named inputs, outputs and parameters of a step program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from supple.errors import ModelError


@dataclass(frozen=True)
class Variable:
    """One input, output or parameter of a machine.

    start : value at the start of the run
    """

    name: str
    unit: str
    description: str
    start: float = 0.0


def check_names(given: Sequence[Variable], outputs: Sequence[Variable]) -> None:
    """ModelError if there is no output, or if two variables have the same name."""
    if not outputs:
        raise ModelError("the machine has no output: name sensors, or points to track")
    names = [variable.name for variable in (*given, *outputs)]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(
                f"two parameters, inputs or outputs would be named '{name}': give them other names"
            )
