"""Simulate a system: one case, by the engine that its bodies call for."""

from __future__ import annotations

import warnings

from supple.body.full_body import FullBody
from supple.errors import ModelError, StepCutWarning
from supple.integrate import (
    FixedStep,
    Run,
    Solution,
    Statistics,
    StepControl,
)
from supple.machine.system import System
from supple.multibody.checks.validity import Peaks, watch
from supple.multibody.compiled.compiled_run import simulate_compiled
from supple.multibody.full.full_order import simulate_full_order
from supple.multibody.run_parts import Checkpoint, Progress, Recorder

__all__ = ["simulate"]


def check_laws_cover(system: System, begin: float, end: float) -> None:
    """Raise ModelError for a tabulated load or motion that starts after the run does, or stops before."""
    laws = [(f"joint '{joint.name}'", joint.law) for joint in system.joints]
    laws += [(load.label, load.law) for load in system.loads]
    for what, law in laws:
        if law is not None and law.begin > begin:
            raise ModelError(
                f"{what}: its table begins at t = {law.begin:g}, after the run does (t = {begin:g}). "
                "Extend the table backwards"
            )
        if law is not None and law.end < end * (1 - 1e-12):
            raise ModelError(
                f"{what}: its table ends at t = {law.end:g}, before the run does (t = {end:g}). "
                "Extend the table or shorten the run"
            )


def simulate(
    system: System,
    run: Run,
    *,
    resume: Checkpoint | None = None,
    progress: Progress | None = None,
    record: Recorder | None = None,
) -> Solution:
    """Motion of a system from its initial state over a run, by generalized-alpha.

    Parameters
    ----------
    system : System     bodies all rigid or reduced (compiled engine), or some full (sparse engine)
    run : Run           span, output times, steps, tolerances
    resume : Checkpoint     go on from the end of an earlier part of the same run
    progress, record : called as the run goes on; `record` receives every completed chunk

    Returns
    -------
    Solution    at the output times; when resuming, only the new ones

    Raises
    ------
    ModelError          a joint open at the start, a table that begins too late or ends too early
    ConvergenceError    a step that fails at the smallest size: time, residual and remedy; what was computed
                        until then has been handed to `record`
    ValidityError       a motion beyond the kinematics, under `Validity(strict=True)`

    Warns
    -----
    ValidityWarning, StepCutWarning, RedundantConstraintWarning
    """
    times = run.times
    check_laws_cover(system, times[0], times[-1])
    if resume is not None and resume.solution.times[-1] >= times[-1] * (1 - 1e-12):
        raise ValueError(
            f"nothing is left to simulate: the recorded part ends at t = {resume.solution.times[-1]:g} and "
            f"the run at t = {times[-1]:g}"
        )
    limits = watch(system, run.validity)
    peaks: dict[str, Peaks] = {}

    def observed(chunk: Solution) -> None:
        if record is not None:
            record(chunk)
        peaks.update(limits.observe(peaks, chunk))

    full = any(isinstance(placed.body, FullBody) for placed in system.bodies)
    engine = simulate_full_order if full else simulate_compiled
    solution = engine(
        system, times, run.step_control, run.method, run.tolerances, resume, progress or _silent, observed
    )
    report_rejected_steps(solution.statistics, run.step_control)
    limits.report(peaks)
    return solution


def _silent(fraction: float) -> None: ...


def report_rejected_steps(statistics: Statistics, step: StepControl) -> None:
    """Warn when steps of a fixed size had to be cut: the answer is good, the step was too long."""
    if statistics.rejected_steps and isinstance(step, FixedStep):
        warnings.warn(
            f"{statistics.rejected_steps} steps did not converge and were cut "
            f"({statistics.steps} steps were taken); a fixed step below {step.size:g} avoids this",
            StepCutWarning,
            stacklevel=3,
        )
