"""Error of intrinsic bodies caused by the number of modes."""

from __future__ import annotations

from supple.integrate import ErrorPart, Solution
from supple.machine import System
from supple.methods.intrinsic import IntrinsicBody
from supple.methods.intrinsic.truncation_error import truncation_parts


def line_parts(system: System, solution: Solution) -> dict[str, ErrorPart]:
    """Error caused by the number of modes, by name of every intrinsic body for which it is known."""
    found = {
        name: ErrorPart(0.0, "no basis: all modes")
        for name, body in system.bodies_of(IntrinsicBody).items()
        if body.complete is None and (body.supported is None or body.supported.complete is None)
    }
    return found | dict(truncation_parts(system, solution))
