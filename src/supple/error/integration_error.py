"""Error of a run caused by the time integration: its step, and the tolerance of Newton's iteration.

Two more runs of the same machine measure this error. The first has a hundredth of the tolerance; the second
has, in addition, half the step. With q the exact motion, q(h) and q(h/2) the motions of these runs, and
q(h) = q + c h^2 + .. for an integrator of second order,

    step = 4/3 |q(h) - q(h/2)|,        newton = max( |q_run - q(h)|, 10 tol |u| ),

both in the norm of the quantity of interest, with tol Newton's tolerance and u the displacement. Where a load
or a prescribed acceleration jumps, a fixed step meets the jump up to half a step too early or too late. This
error is of first order, q(h) = q + c h + .., and halves with the step. The stated error of the step is then
its bound 2 |q(h) - q(h/2)|. Adaptive steps with local error e have a global error of about e^(2/3). For
these, the second run has an eighth of the local error and half the largest step. Newton's tolerance is
relative to the forces in balance. The remaining error is therefore at least about ten times tol |u|: the
floor of the integration error, and the smallest value stated for Newton's tolerance.
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

HALF = 0.5
TIGHTER = 1e-2
"""Newton's tolerance of the two runs over that of the assessed run."""
RICHARDSON = 4 / 3
"""1 / (1 - HALF^2): error of second order over its change from h to h/2."""
AT_JUMPS = 2.0
"""1 / (1 - HALF): error of first order over its change from h to h/2."""
FLOOR = 10.0
"""Ratio of the floor of the error to displacement times Newton's tolerance."""
TIGHTEST = 1e-12
"""Smallest relative residual above round-off."""


@dataclass(frozen=True)
class IntegrationError:
    """Errors of the step (None if not estimated) and of Newton's tolerance for one quantity."""

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
    """Errors of a finished run caused by the step and by the tolerance, by name of the quantity.

    Parameters
    ----------
    system, run, solution : machine, settings and result of the assessed run
    measured : bool     make the two runs; False: only the floor of the integration error
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
    """Floor of the integration error with these tolerances, in a quantity of the given size."""
    return FLOOR * tolerances.residual * size


def with_tolerance(run: Run, residual: float) -> Run:
    """The run with another relative residual as tolerance of Newton's iteration."""
    return replace(run, tolerances=replace(run.tolerances, residual=residual))


def with_shorter_steps(run: Run, factor: float) -> Run:
    """The run with steps multiplied by a factor below one, and local errors by its third power."""
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
    """The smallest step for a run with another first step."""
    return None if step.smallest is None else min(step.smallest, first)


def _quiet(system: System, run: Run, words: str, progress: StepProgress | None) -> Solution:
    """A comparison run without warnings: the assessed run has reported them already."""
    share = None if progress is None else lambda fraction: progress(words, fraction)
    if progress is not None:
        progress(words, 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SuppleWarning)
        return watched_run(system, replace(run, validity=Validity()), progress=share, check=False)


def _remedy_of_step(run: Run, whole: float) -> str:
    if isinstance(run.step_control, FixedStep):
        left = (
            "a half because a load jumps; adaptive steps stop at jumps" if whole == AT_JUMPS else "a quarter"
        )
        return f"halve the step of {fixed_step(run):.3g}, which leaves {left}"
    local = run.step_control.tolerance
    return f"allow a local error below {local:.3g}: an eighth of it leaves a quarter of the step's error"


_ADAPTIVE = "a run with an eighth of the local error"
_TIGHTEN = "tighten the tolerance of Newton's iteration"
