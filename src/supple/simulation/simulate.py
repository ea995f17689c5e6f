"""Simulate a system: one case, by the engine that its bodies call for."""

from __future__ import annotations

import warnings

import numpy as np

from supple.body.full_body import FullBody
from supple.errors import ModelError, StepCutWarning
from supple.integrate import (
    FixedStep,
    GeneralizedAlpha,
    Solution,
    Statistics,
    StepControl,
    TimeIntegrator,
    Tolerances,
)
from supple.machine.system import System
from supple.multibody.checks.validity import Peaks, Validity, watch
from supple.multibody.compiled.compiled_run import simulate_compiled
from supple.multibody.full.full_order import simulate_full_order
from supple.multibody.run_parts import Checkpoint, Progress, Recorder

__all__ = ["output_times", "simulate"]


def output_times(duration: float, output_step: float, start: float = 0.0) -> np.ndarray:
    """`start, start + output_step, .. , start + duration`; the duration must be a multiple of the step."""
    for name, value in (("duration", duration), ("output_step", output_step)):
        if not (np.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be a positive, finite number, got {value}")
    n = round(duration / output_step)
    if n < 1 or abs(n * output_step - duration) > 1e-6 * output_step:
        raise ValueError(
            f"the duration ({duration}) is not a multiple of the output step ({output_step}): "
            f"try an output step of {duration / max(n, 1):.6g}"
        )
    return start + np.arange(n + 1) * (duration / n)


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
    *,
    duration: float,
    output_step: float,
    step: StepControl | None = None,
    method: TimeIntegrator | None = None,
    tolerances: Tolerances | None = None,
    validity: Validity | None = None,
    resume: Checkpoint | None = None,
    progress: Progress | None = None,
    record: Recorder | None = None,
) -> Solution:
    """Motion of a system from its initial state over a duration, by generalized-alpha.

    Parameters
    ----------
    system : System     bodies all rigid or reduced (compiled engine), or some full (sparse engine)
    duration, output_step : float   unit of time; the duration is a multiple of the output step
    step : FixedStep | AdaptiveStep     default: a fixed step equal to the output step
    method : GeneralizedAlpha (default, rho_inf = 0.8) | Newmark | HilberHughesTaylor
    tolerances : Tolerances
    validity : Validity     warn of a motion beyond what the kinematics allow (default), or stop at it
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
    times = output_times(duration, output_step)
    step = step or FixedStep(output_step)
    method = method or GeneralizedAlpha()
    tolerances = tolerances or Tolerances()
    check_laws_cover(system, times[0], times[-1])
    if resume is not None and resume.solution.times[-1] >= times[-1] * (1 - 1e-12):
        raise ValueError(
            f"nothing is left to simulate: the recorded part ends at t = {resume.solution.times[-1]:g} and "
            f"the run at t = {times[-1]:g}"
        )
    limits = watch(system, validity or Validity())
    peaks: dict[str, Peaks] = {}

    def observed(chunk: Solution) -> None:
        if record is not None:
            record(chunk)
        peaks.update(limits.observe(peaks, chunk))

    full = any(isinstance(placed.body, FullBody) for placed in system.bodies)
    engine = simulate_full_order if full else simulate_compiled
    solution = engine(system, times, step, method, tolerances, resume, progress or _silent, observed)
    report_rejected_steps(solution.statistics, step)
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
