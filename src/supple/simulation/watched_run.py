"""A run in memory, checked before and during its march."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

from supple.algebra.jax_settings import before_compiled_code
from supple.equations.checks.joint_residuals import check_redundant_joints
from supple.equations.checks.output_rate import report_output_rate
from supple.equations.checks.rate_jumps import warn_of_rate_jumps
from supple.equations.checks.step_resolution import report_step_length, warn_of_missed_loads
from supple.equations.checks.validity import watch
from supple.equations.stops import laws_of
from supple.errors import ConvergenceError, ModelError, StepCutWarning
from supple.integrate import FixedStep, Progress, Recorder, Run, Solution, Statistics, StepControl
from supple.integrate import run as march_through
from supple.machine import System
from supple.machine.laws.time_law import begins_after, ends_before
from supple.methods.explicit.deleted_faces import deletion_watch
from supple.methods.explicit.shell_strain import shell_strain_watch
from supple.methods.explicit.yielding import yield_watch
from supple.methods.intrinsic.truncation_error import report_truncation
from supple.simulation.engines import engine_for, is_explicit
from supple.simulation.half_revolutions import report_half_revolutions
from supple.simulation.recorded_columns import measured_columns


def watched_run(
    system: System,
    run: Run,
    *,
    resume: Solution | None = None,
    progress: Progress | None = None,
    record: Recorder | None = None,
    check: bool = True,
) -> Solution:
    """Run a machine by its engine, with checks and warnings; parameters and result as for `simulate`."""
    before_compiled_code()
    times = run.times
    check_laws_cover(system, times[0], times[-1])
    warn_of_unseen_laws(system, run)
    watches = (
        watch(system, run.validity),
        yield_watch(system, run.validity),
        deletion_watch(system, run.validity),
        shell_strain_watch(system, run.validity),
    )
    peaks: list[Any] = [{} for _ in watches]

    def observed(leg: Solution) -> None:
        check_redundant_joints(system, leg)  # an erroneous leg is not recorded
        if record is not None:
            record(leg)
        peaks[:] = [own.observe(so_far, leg) for own, so_far in zip(watches, peaks, strict=True)]
        if run.validity.strict:
            report_step_length(leg.statistics, run)

    def report_limits() -> None:
        for own, found in zip(watches, peaks, strict=True):
            own.report(found)

    engine = engine_for(system, run)
    try:
        solution = march_through(
            engine, times, resume=resume, progress=progress, record=observed, check=check
        )
    except ConvergenceError:
        if any(peaks):  # the limits exceeded may be the cause of the early end
            report_limits()
        raise
    _report_rejected_steps(solution.statistics, run.step_control)
    report_limits()
    report_half_revolutions(system, run, solution)
    report_resolution(system, run, solution)
    return replace(report_truncation(system, run, solution), columns=measured_columns(system))


def report_resolution(system: System, run: Run, solution: Solution) -> None:
    """Warn (ResolutionWarning) if steps, or output times, are too far apart for the motion."""
    report_step_length(solution.statistics, run)
    report_output_rate(system, run, solution)


def warn_of_unseen_laws(system: System, run: Run) -> None:
    """Warn (ResolutionWarning) of prescribed motions that jump, and loads that fixed steps do not resolve."""
    if run.step is None and is_explicit(system, run):
        return  # explicit steps are short, whatever the output step
    named = warn_of_rate_jumps(system, run)
    warn_of_missed_loads(system, run, besides=named)


def check_laws_cover(system: System, begin: float, end: float) -> None:
    """Raise ModelError for a table that begins after the start of the run or ends before its end."""
    for what, law in laws_of(system):
        if begins_after(law, begin):
            raise ModelError(
                f"{what}: its table begins at t = {law.begin:g}, after the run begins (t = {begin:g}). "
                "Extend the table backwards"
            )
        if ends_before(law, end):
            raise ModelError(
                f"{what}: its table ends at t = {law.end:g}, before the run ends (t = {end:g}). "
                "Extend the table or shorten the run"
            )


def _report_rejected_steps(statistics: Statistics, step: StepControl) -> None:
    """Warn when steps of a fixed size were shortened: the result is valid, but the given step is too long."""
    if statistics.rejected_steps and isinstance(step, FixedStep):
        warnings.warn(
            f"{statistics.rejected_steps} steps did not converge and were cut "
            f"({statistics.steps} steps were taken); a fixed step below {step.size:g} avoids this",
            StepCutWarning,
            stacklevel=3,
        )
