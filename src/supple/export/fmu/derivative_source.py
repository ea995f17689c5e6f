"""Directional derivatives of a machine's outputs with respect to its inputs, in C."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

from supple.export.c.function import HEAD, named_view, printed_function
from supple.export.c.machine_source import struct_fields
from supple.stepping import StepProgram, StepState

__all__ = ["derivative_source"]


def derivative_source(step: StepProgram) -> str:
    """The text of `derivative.c`: derivatives of the outputs along a direction of the inputs.

    The function computes `d output(end)/d input . direction` of the discrete time step, with inputs constant
    until `end`, by JAX's forward mode.

    Raises ModelError for an operation of the derivative without a translation to C.
    """

    def rates(now: StepState, end: Any, direction: Any) -> Any:
        def outputs(given: Any) -> Any:
            return step.advanced(now._replace(input=given), end).output

        return jax.jvp(outputs, (now.input,), (direction,))[1]

    views = [each.view for each in struct_fields(step.start)]
    end = named_view("end", (), np.float64, is_scalar=True)
    direction = named_view("direction", step.start.input.shape, np.float64)
    result = named_view("rates", step.start.output.shape, np.float64)
    arguments = (step.start, np.float64(0.0), np.zeros_like(step.start.input))
    parameters = [
        ("const machine *m", "m"),
        ("double end", "end"),
        ("const double *direction", "direction"),
        ("double *rates", "rates"),
    ]
    inputs = [*views, end, direction]
    printed = printed_function(rates, arguments, inputs, [result], "derivative", parameters)
    return (
        f'#include "machine.h"\n\n{HEAD}\n{printed.before}\n\n'
        f"void machine_derivative({', '.join(own for own, _ in parameters)})\n"
        f"{{\n{printed.body}\n}}\n"
    )
