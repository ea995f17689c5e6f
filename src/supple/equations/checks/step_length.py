"""Check that a fixed step was short enough: largest local error and rotation of a run, with the remedy."""

from __future__ import annotations

from supple.equations.checks.strictness import warn_or_raise
from supple.errors import ResolutionWarning
from supple.integrate import FixedStep, Kinematic, Run, Statistics

__all__ = ["report_step_length"]

LARGEST_ERROR = 1e-2
"""Largest local error of a step without a warning, as defined for `AdaptiveStep`."""
LARGEST_TURN = 0.5
"""rad, largest rotation of a body within a step without a warning."""


def report_step_length(statistics: Statistics, run: Run) -> None:
    """Warn (ResolutionWarning) of a fixed step with a large local error, or a large rotation of a body.

    Raises ValidityError instead in a strict run.
    """
    step = run.step_control
    if not isinstance(step, FixedStep):
        return
    found, shorter = [], 1.0
    if statistics.largest_error > LARGEST_ERROR:
        found.append(f"its local error reaches {statistics.largest_error:.2g} of the machine's size, or rad")
        shorter = (LARGEST_ERROR / statistics.largest_error) ** (1 / 3)  # the local error is of third order
    if statistics.largest_turn > LARGEST_TURN:
        found.append(f"a body rotates by {statistics.largest_turn:.2g} rad within it")
        shorter = min(shorter, LARGEST_TURN / statistics.largest_turn)
    if found:
        instead = "" if isinstance(run.method, Kinematic) else ", or adaptive steps"
        message = (
            f"the fixed step of {step.size:.3g} is too long for this motion: {' and '.join(found)}. Take "
            f"{step.size * shorter:.1g} or less{instead}"
        )
        warn_or_raise(message, ResolutionWarning, run.validity)
