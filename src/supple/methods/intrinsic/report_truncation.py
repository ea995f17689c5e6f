"""Check of the number of modes after a run: a warning, or an error where the run is strict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from supple.equations.checks.strictness import warn_or_raise
from supple.errors import ValidityWarning
from supple.integrate import ErrorPart, Run, Solution
from supple.machine import System
from supple.methods.intrinsic.complete_motion import intrinsic_of
from supple.methods.intrinsic.intrinsic_body import body_of
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.supported_root import is_joined
from supple.methods.intrinsic.truncation_error import TruncationError, truncation_error

__all__ = ["report_truncation", "report_truncation_of_cases", "truncation_parts"]

LARGEST = 1e-2
"""Truncation error relative to the deflection, above which a warning is issued."""


def truncation_parts(system: System, solution: Solution) -> Mapping[str, ErrorPart]:
    """Truncation part of the error, by body: that of the run, or computed if the run has none."""
    return solution.truncation or {name: _part(each) for name, each in _errors(system, solution).items()}


def report_truncation(system: System, run: Run, solution: Solution) -> Solution:
    """The solution with `truncation`, the part of its error due to omitted modes.

    Warns (ValidityWarning; an error in a strict run) of bodies with a truncation error above 1 % of the
    deflection.
    """
    errors = _errors(system, solution)
    for name, error in errors.items():
        _warn(system, run, name, error)
    return replace(solution, truncation={name: _part(error) for name, error in errors.items()})


def report_truncation_of_cases(cases: Sequence[System], run: Run, solutions: Sequence[Solution]) -> None:
    """Warn about the largest truncation error of a batch, with each body in its most strained case."""
    finished = [number for number, solution in enumerate(solutions) if solution.stopped is None]
    if not finished:
        return
    found: dict[int, dict[str, TruncationError]] = {}
    worst: tuple[float, int, str] | None = None
    for placed in intrinsic_of(cases[0]):
        name = placed.body.name
        number = max(finished, key=lambda n, name=name: _strain(cases[n], solutions[n], name))
        if number not in found:
            found[number] = _errors(cases[number], solutions[number])
        if name in found[number]:
            worst = max(worst or (0.0, 0, ""), (found[number][name].largest, number, name))
    if worst is not None:
        _, number, name = worst
        _warn(cases[number], run, name, found[number][name], where=f"case {number}: ")


def _strain(system: System, solution: Solution, name: str) -> float:
    """Square root of twice the largest strain energy of a body in a run."""
    body = body_of(system.bodies[system.body_index(name)])
    forces = body.forces_of(solution.motion(name, IntrinsicMotion).coordinates)
    return float(np.linalg.norm(forces, axis=1).max(initial=0.0))


def _errors(system: System, solution: Solution) -> dict[str, TruncationError]:
    """`truncation_error` of the bodies with omitted modes; none for machines with controllers."""
    few = any(body_of(placed).complete is not None for placed in intrinsic_of(system))
    known = not is_joined(system) or all(joint.name in solution.multipliers for joint in system.joints)
    estimated = few and known and not system.controllers and solution.stopped is None
    return truncation_error(system, solution) if estimated else {}


def _warn(system: System, run: Run, name: str, error: TruncationError, where: str = "") -> None:
    if error.largest <= LARGEST:
        return
    body = system.bodies[system.body_index(name)].body
    why = (
        f"its centre of mass drifts by {error.drift:.2g} from the path due to its loads"
        if error.drifts
        else f"with all modes its stations would move by {max(error.places):.2g} (RMS)"
    )
    warn_or_raise(
        f"{where}body '{name}': {body.n_coordinates} modes are too few: {why}, which is {error.largest:.1%} "
        "of its deflection. Keep more modes, or omit their number: then all modes are kept, or as many as a "
        "given accuracy needs",
        ValidityWarning,
        run.validity,
    )


def _part(error: TruncationError) -> ErrorPart:
    return ErrorPart(
        max(error.drift, *error.places),
        "drift of the centre of mass"
        if error.drifts
        else "omitted modes follow the motion statically, at a few instants",
        "keep more modes",
    )
