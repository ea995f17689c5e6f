"""Whether the modes of a finished run were enough: a warning, or an error where the run is strict."""

from __future__ import annotations

from supple.errors import ValidityWarning
from supple.integrate import Run, Solution
from supple.intrinsic.intrinsic_body import IntrinsicBody
from supple.intrinsic.supported_root import is_joined
from supple.intrinsic.truncation_error import TruncationError, truncation_error
from supple.machine import System
from supple.multibody.checks.strictness import say

__all__ = ["known_truncation", "report_truncation"]

LARGEST = 1e-2
"""Of the deflection."""


def known_truncation(system: System, solution: Solution) -> dict[str, TruncationError]:
    """`truncation_error` of the bodies that leave modes out; empty where joints connect bodies."""
    bodies = [placed.body for placed in system.bodies]
    few = [body for body in bodies if isinstance(body, IntrinsicBody) and body.complete is not None]
    if not few or is_joined(system) or solution.stopped is not None:
        return {}
    return truncation_error(system, solution)


def report_truncation(system: System, run: Run, solution: Solution) -> None:
    """Warn ValidityWarning of modes left out that would change places by 1 % of the deflection."""
    for name, error in known_truncation(system, solution).items():
        if error.largest <= LARGEST:
            continue
        body = system.bodies[system.body_index(name)].body
        drifted = error.drift > max(error.places)
        why = (
            f"its centre of mass drifts by {error.drift:.2g} from where its loads bring it"
            if drifted
            else f"all modes would move its stations by {max(error.places):.2g}, RMS"
        )
        say(
            f"body '{name}': {body.n_coordinates} modes are too few: {why}, which is {error.largest:.1%} of its "
            "deflection. Keep more modes, or leave their number out: all are kept then, or as many as an "
            "accuracy needs",
            ValidityWarning,
            run.validity,
        )
