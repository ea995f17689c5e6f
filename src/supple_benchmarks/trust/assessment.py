"""Assessment of one case: estimated errors, compared with the distances from full runs.

The basis errors of the rounds are compared with full runs with the same steps, the total error with a full
run with an eighth of the step.

All reference runs have a hundredth of the run's Newton tolerance.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from supple.body import FullBody
from supple.error import (
    CorrectedSystem,
    ErrorEstimator,
    ErrorStudy,
    ReductionStart,
    Round,
    self_correct,
    system_corrections,
)
from supple.error.integration_error import with_shorter_steps, with_tolerance
from supple.errors import SuppleError, SuppleWarning
from supple.integrate import PARTS, Run, Solution
from supple.machine import System
from supple.quantities import WholeBody
from supple.quantities.quantity_of_interest import quantity_distance
from supple.results import motion_error
from supple.simulation import simulate
from supple_benchmarks.table import Row
from supple_benchmarks.trust.trust_case import TrustCase, file_name

__all__ = ["assess"]

EIGHTH = 1 / 8
TIGHT = 1e-2
"""Newton tolerance of the reference runs, relative to that of the run."""


def assess(case: TrustCase, folder: Path, progress: Callable[[float], None]) -> Row:
    """The record of a case; its full runs are stored in the folder, and read if present."""
    system, rounds = case.system(), []
    began = perf_counter()
    start = ReductionStart(case.target, case.basis, case.derivatives)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SuppleWarning)
        try:
            corrected = self_correct(system, case.run, start, announce=rounds.append, study=ErrorStudy())
            reason = ""
        except SuppleError as error:
            corrected, reason = None, str(error)
        seconds = perf_counter() - began
        progress(0.4)
        full_runs = _FullRuns(case, system, folder)
        assessed = [_round_record(each, system, full_runs) for each in rounds]
        progress(0.7)
        last = case.run if corrected is None else corrected.run or case.run
        record: Row = {
            "name": case.name,
            "freedoms": sum(body.n_coordinates for body in _fulls(system).values()),
            "rounds": assessed,
            "accepted": corrected is not None,
            "allowed": min((each.allowed for each in rounds[-len(_fulls(system)) :]), default=0.0),
            "parts": dict.fromkeys(PARTS),
            "true_total": None,
            "cost": None,
            "seconds": seconds,
            "full_seconds": full_runs.at(last).statistics.seconds,
            "accuracy": case.accuracy,
            "step": float(last.step_control.first),
            "reason": reason,
        }
        if corrected is not None:
            exact = full_runs.at(
                with_tolerance(with_shorter_steps(last, EIGHTH), TIGHT * last.tolerances.residual)
            )
            record |= _worst(corrected.system, corrected.solution, system, exact)
            record["cost"] = _cost(system, corrected, last)
    progress(1.0)
    return record


def _cost(system: System, corrected: CorrectedSystem, run: Run) -> Row:
    """Processor time of the accepted run and of its basis error estimate, without compilation.

    The estimate includes factorisations of the full system; as many factorisations are timed separately.
    """
    bases = {name: own.basis for name, own in corrected.bodies.items()}
    simulate(corrected.system, run, check=False)  # the first time compiles
    ErrorEstimator(system, run).assess(corrected.system, bases, corrected.solution)
    began = process_time()
    simulate(corrected.system, run, check=False)
    simulated = process_time()
    estimate = ErrorEstimator(system, run).assess(corrected.system, bases, corrected.solution)
    estimated = process_time()
    n_times = len(corrected.solution.times)
    instants = np.linspace(1, n_times - 1, estimate.factorizations).round().astype(int)
    system_corrections(corrected.system, tuple(_fulls(system).values()), bases, corrected.solution, instants)
    return {
        "coordinates": sum(basis.r for basis in bases.values()),
        "steps": corrected.solution.statistics.steps,
        "run_seconds": simulated - began,
        "estimator_seconds": estimated - simulated,
        "factorizations": estimate.factorizations,
        "factorization_seconds": process_time() - estimated,
    }


def _fulls(system: System) -> dict[str, FullBody]:
    return system.bodies_of(FullBody)


def _worst(reduced: System, solution: Solution, system: System, exact: Solution) -> Row:
    """Error parts and total error of the body with the largest ratio to its allowed error."""

    def true(name: str) -> float:
        return quantity_distance(WholeBody(name), reduced, solution, system, exact)

    name = max(_fulls(system), key=lambda each: true(each) / (solution.errors[each].allowed or 1.0))
    stated = solution.errors[name]
    return {
        "allowed": stated.allowed,
        "parts": {part: stated.parts[part].value if part in stated.parts else None for part in PARTS},
        "stated_total": stated.total,
        "true_total": true(name),
        "advice": stated.advice,
    }


def _round_record(each: Round, system: System, full_runs: _FullRuns) -> Row:
    name = each.body.name
    run = each.run or full_runs.case.run
    # The same steps, but a tighter tolerance, so that the residual of the reference does not matter.
    full = full_runs.at(with_tolerance(run, TIGHT * run.tolerances.residual))
    true = np.inf
    # A run with a reduced step has other steps than any full run: the difference includes a step error.
    same_steps = each.solution.statistics.steps == full.statistics.steps
    if each.solution.stopped is None and full.stopped is None and same_steps:
        true = motion_error(full, _fulls(system)[name], each.solution, each.body, body=name).max_rms
    return {
        "body": name,
        "size": each.size,
        "estimated": each.estimated_error if np.isfinite(each.estimated_error) else None,
        "true": true if np.isfinite(true) else None,
    }


class _FullRuns:
    """Full runs of a case, stored on disk by their steps and tolerances."""

    def __init__(self, case: TrustCase, system: System, folder: Path) -> None:
        self.case = case
        self._system = system
        self._folder = folder / file_name(case.name)
        self._known: dict[str, Solution] = {}

    def at(self, run: Run) -> Solution:
        """The full run with these settings, read from disk if it is stored, else computed."""
        step = run.step_control
        key = f"{step.first!r}-{run.tolerances.residual!r}"
        if key not in self._known:
            self._known[key] = simulate(self._system, run, file=self._folder / f"{key}.h5", check=False)
        return self._known[key]
