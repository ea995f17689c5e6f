"""Exudyn and supple with the same step and tolerance on one thread, alternating; the best run counts."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from time import perf_counter
from typing import Any

import numpy as np

from supple.methods.floating.compiled import programs

Outcome = tuple[int, int, float, np.ndarray]
"""Steps, Newton iterations, wall seconds, and the positions (t, 3) of a point at the output times."""
TimedRun = Callable[[], Outcome]


def exudyn() -> Any:
    """The module; exits with a message if it is not installed."""
    try:
        import exudyn as exu
    except ImportError:
        sys.exit("this comparison needs Exudyn, which is not installed here: pip install exudyn==1.13.6")
    return exu


def timed_run(
    mbs: Any,
    sensor: int,
    *,
    duration: float,
    step: float,
    output_step: float,
    tolerance: float,
    modified_newton: bool,
    linear_solver: str = "EXUdense",
) -> TimedRun:
    """Run an assembled system by generalized-alpha, rho_inf = 0.8, as often as called.

    linear_solver : str     a member of Exudyn's `LinearSolverType`
    """
    exu = exudyn()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(duration / step)
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    settings.timeIntegration.newton.relativeTolerance = tolerance
    settings.timeIntegration.newton.useModifiedNewton = modified_newton
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = output_step
    settings.parallel.numberOfThreads = 1
    settings.linearSolver.solverType = getattr(exu.LinearSolverType, linear_solver)

    def run() -> Outcome:
        began = perf_counter()
        mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
        seconds = perf_counter() - began
        iterations = int(mbs.sys["dynamicSolver"].it.newtonStepsCount)
        return (
            settings.timeIntegration.numberOfSteps,
            iterations,
            seconds,
            mbs.GetSensorStoredData(sensor)[:, 1:4],
        )

    return run


def march_as_long_runs_do() -> None:
    """Use the program of long runs in every run of supple.

    Runs as short as these would use a program that is compiled in a third of the time and has slower steps.
    """
    programs.ends_before_compiling = lambda *_: False


def best_of(runs: Mapping[str, TimedRun], repeats: int) -> dict[str, Outcome]:
    """The fastest outcome of each code; the codes alternate, so that other load affects all alike."""
    for run in runs.values():
        run()  # compiles, warms the caches
    best: dict[str, Outcome] = {}
    for _ in range(repeats):
        for code, run in runs.items():
            outcome = run()
            if code not in best or outcome[2] < best[code][2]:
                best[code] = outcome
    return best
