"""Time integration shared by all methods: legs, recording, progress, resumption, failure."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter
from typing import TypeVar

import numpy as np

from supple.blas_threads import one_blas_thread
from supple.errors import ConvergenceError, ModelError
from supple.integrate.engine import Engine, Progress, Recorder
from supple.integrate.solution import Solution, Statistics, concatenate

__all__ = ["leg_size", "run"]

S = TypeVar("S")

LEGS = 50
"""Largest number of legs of a run after its initial state."""
FEWEST_LEGS = 8
"""Approximate smallest number of legs: `Engine.least_leg` makes legs longer only down to this number, so that
progress and results are available during a short run."""


def run(
    engine: Engine[S],
    times: np.ndarray,
    *,
    resume: Solution | None = None,
    progress: Progress | None = None,
    record: Recorder | None = None,
    check: bool = True,
) -> Solution:
    """Integrate a machine through the output times of a run by its engine.

    Parameters
    ----------
    times : (t,)            all output times of the run, the initial one first
    resume : Solution       the recorded part: the run continues from its last time
    progress, record : called after each leg, first `record`; `progress` not after the initial state
    check : bool            raise if the run ends early; if False, `Solution.stopped` states the cause

    Returns
    -------
    Solution    at the output times; when resuming, only the new ones

    Raises
    ------
    ValueError          no output time is left to simulate
    ModelError          `resume` without the state of the engine, where the engine needs it
    ConvergenceError    the run ended early, with `check` or before any output time was reached; the results
                        until then were passed to `record`
    """
    began = perf_counter()
    if resume is None:
        state = engine.start(float(times[0]))
        # The initial state is a separate leg: it is recorded before the first step.
        legs = [times[:1], *_legs(times, times[1:], engine.least_leg)]
    else:
        left = _times_left(times, float(resume.times[-1]))
        try:
            state = engine.resumed(resume)
        except KeyError as error:
            if str(error.args[0]) in resume.engine_state:
                raise
            raise ModelError(
                f"cannot continue from this solution: the state of its engine lacks {error}. Give the "
                "solution that `simulate` returned for this run, or its file: `at` omits that state. To "
                "begin a new run from a motion, use Start(solution, time)"
            ) from error
        legs = _legs(times, left, engine.least_leg)
    preparing = Statistics(compile_seconds=perf_counter() - began)
    parts: list[Solution] = []
    n_times = sum(len(leg) for leg in legs)
    n_done = 0
    for leg_times in legs:
        with one_blas_thread():
            leg = engine.march(state, leg_times)
        state = leg.last
        n_done += len(leg_times)
        if leg.n_reached:
            part = engine.solution(leg)
            if not parts:
                part = replace(part, statistics=part.statistics + preparing)
            parts.append(replace(part, stopped=leg.stopped))
            if record is not None:
                record(parts[-1])
        if leg.stopped is not None:
            if check or not parts:
                raise ConvergenceError(leg.stopped)
            return replace(concatenate(parts), stopped=leg.stopped)
        if progress is not None and (resume is not None or len(parts) > 1):
            progress(n_done / n_times)
    return concatenate(parts)


def _legs(times: np.ndarray, left: np.ndarray, least: int) -> list[np.ndarray]:
    """Remaining output times of a run, leg by leg; `least` is `Engine.least_leg`."""
    size = max(leg_size(len(times)), min(least, int(np.ceil((len(times) - 1) / FEWEST_LEGS))))
    return [left[begin : begin + size] for begin in range(0, len(left), size)]


def leg_size(n_times: int) -> int:
    """Number of output times of a leg after the initial state; the last leg may have fewer."""
    return max(1, int(np.ceil((n_times - 1) / LEGS)))


def _times_left(times: np.ndarray, reached: float) -> np.ndarray:
    """Output times after the last one reached; ValueError if there are none."""
    tolerance = 1e-6 * float(times[1] - times[0])
    left = times[times > reached + tolerance]
    if not left.size:
        raise ValueError(
            f"nothing is left to simulate: the recorded part ends at t = {reached:g} and "
            f"the run at t = {times[-1]:g}; give a longer duration to continue"
        )
    return left
