"""What the time integration costs a run: its step, and the tolerance of Newton's iteration.

Two more runs of the same machine show it, one with a hundredth of the tolerance, one besides with half the
step. With q(h) their motions and an integrator of second order, q(h) = q + c h^2 + ..,

    step = 4/3 |q(h) - q(h/2)|,        newton = max( |q_run - q(h)|, 10 tol |u| ),

both in the norm of the quantity of interest. Where a load jumps, a fixed step sees the jump up to half a
step too early or too late, an error of first order, q(h) = q + c h + .., which falls by 2 instead of 4: there
the step costs 2 |q(h) - q(h/2)| at most, and so much is stated. Adaptive steps of a local error tol have a
global one of about tol^(2/3): an eighth of the tolerance, and half the largest step, stand for half the step.
The tolerance is relative to the forces in balance, so what it leaves is no smaller than some parts of the
displacement |u| times it: the floor of the integration, below which nothing is stated.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil

from supple.equations.checks.step_resolution import fixed_step, jumps_in_steps
from supple.errors import SuppleWarning
from supple.integrate import (
    AdaptiveStep,
    ErrorPart,
    FixedStep,
    Run,
    Solution,
    StepControl,
    StepProgress,
    Tolerances,
    Validity,
)
from supple.machine import System
from supple.quantities.quantity_of_interest import QuantityOfInterest, quantity_distance
from supple.simulation.watched_run import watched_run

__all__ = ["IntegrationError", "floor_of", "integration_errors", "with_shorter_steps", "with_tolerance"]

HALF = 0.5
TIGHTER = 1e-2
"""Of the tolerance of the run: that of the runs it is compared with."""
RICHARDSON = 4 / 3
"""1 / (1 - HALF^2): the whole of an error of second order over its change from h to h/2."""
AT_JUMPS = 2.0
"""The same of an error of first order."""
FLOOR = 10.0
"""Displacements times tolerances below which nothing is stated."""
TIGHTEST = 1e-12
"""Relative residual that rounding still allows to ask for."""


@dataclass(frozen=True)
class IntegrationError:
    """The two parts of one quantity; None where not estimated."""

    step: ErrorPart | None
    newton: ErrorPart


def integration_errors(
    system: System,
    run: Run,
    solution: Solution,
    quantities: Sequence[QuantityOfInterest],
    *,
    measured: bool = True,
    progress: StepProgress | None = None,
) -> Mapping[str, IntegrationError]:
    """Error of the step and of the tolerance of a finished run in some quantities, by their names.

    Parameters
    ----------
    system, run, solution : whose error is stated
    measured : bool     make the two runs; otherwise the floor of the integration is all that is stated
    """
    floors = {each.name: floor_of(run.tolerances, each.size(system, solution)) for each in quantities}
    if not measured:
        return {
            name: IntegrationError(None, ErrorPart(floor, "floor of the integration", _TIGHTEN))
            for name, floor in floors.items()
        }
    tight_run = with_tolerance(run, max(TIGHTER * run.tolerances.residual, TIGHTEST))
    fine_run = with_shorter_steps(tight_run, HALF)
    tight = _quiet(system, tight_run, "the same run with a tighter tolerance", progress)
    fine = _quiet(system, fine_run, "the same run with half the step", progress)
    words = "a run with half the step" if isinstance(run.step_control, FixedStep) else _ADAPTIVE
    whole = AT_JUMPS if jumps_in_steps(system, run) else RICHARDSON
    found = {}
    for each in quantities:
        halved = quantity_distance(each, system, tight, system, fine)
        loose = quantity_distance(each, system, solution, system, tight)
        floor = floors[each.name]
        is_floor = not loose > floor
        found[each.name] = IntegrationError(
            step=ErrorPart(whole * halved, words, _remedy_of_step(run, whole)),
            newton=ErrorPart(
                floor if is_floor else loose,
                "floor of the integration" if is_floor else "a run with a hundredth of the tolerance",
                _TIGHTEN,
            ),
        )
    return found


def floor_of(tolerances: Tolerances, size: float) -> float:
    """What an integration with these tolerances may leave of a quantity of a size, whatever was measured."""
    return FLOOR * tolerances.residual * size


def with_tolerance(run: Run, residual: float) -> Run:
    """The run with another tolerance of Newton's iteration."""
    return replace(run, tolerances=replace(run.tolerances, residual=residual))


def with_shorter_steps(run: Run, factor: float) -> Run:
    """The run with steps shorter by a factor below one, or local errors smaller by its third power."""
    step = run.step_control
    if isinstance(step, AdaptiveStep):
        shorter = AdaptiveStep(
            first=factor * step.first,
            largest=factor * step.largest,
            tolerance=factor**3 * step.tolerance,
            smallest=_below(step, factor * step.first),
        )
    else:
        interval = float(run.times[1] - run.times[0])
        size = interval / ceil(interval / (factor * float(fixed_step(run))) * (1 - 1e-9))
        shorter = FixedStep(size, smallest=_below(step, size))
    return replace(run, step=shorter)


def _below(step: StepControl, first: float) -> float | None:
    """The smallest step of a run that begins with another first one."""
    return None if step.smallest is None else min(step.smallest, first)


def _quiet(system: System, run: Run, words: str, progress: StepProgress | None) -> Solution:
    """A run that is only measured: the run that is assessed has given its warnings."""
    share = None if progress is None else lambda fraction: progress(words, fraction)
    if progress is not None:
        progress(words, 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SuppleWarning)
        return watched_run(system, replace(run, validity=Validity()), progress=share, check=False)


def _remedy_of_step(run: Run, whole: float) -> str:
    if isinstance(run.step_control, FixedStep):
        left = "a half, as a load jumps: adaptive steps stop there" if whole == AT_JUMPS else "a quarter"
        return f"halve the step of {fixed_step(run):.3g}, which leaves {left}"
    return f"ask for a smaller local error than {run.step_control.tolerance:.3g}; an eighth leaves a quarter"


_ADAPTIVE = "a run with an eighth of the local error"
_TIGHTEN = "tighten the tolerance of Newton's iteration"
