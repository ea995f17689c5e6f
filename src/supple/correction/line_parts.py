"""The part of the modes in the error of intrinsic bodies: what all modes would make of their motion."""

from __future__ import annotations

from supple.integrate import ErrorPart, Solution
from supple.intrinsic import IntrinsicBody
from supple.intrinsic.report_truncation import known_truncation
from supple.machine import System

__all__ = ["line_parts"]


def line_parts(system: System, solution: Solution) -> dict[str, ErrorPart]:
    """By name of every intrinsic body whose part is known: not where joints connect bodies of few modes."""
    found = {
        name: ErrorPart(0.0, "no basis: all modes")
        for name, body in system.bodies_of(IntrinsicBody).items()
        if body.complete is None
    }
    for name, error in known_truncation(system, solution).items():
        drifts = error.drift > max(error.places)
        found[name] = ErrorPart(
            max(error.drift, *error.places),
            "drift of the centre of mass" if drifts else "all modes at rest in the motion, at a few instants",
            "keep more modes",
        )
    return found
