"""Self-correction of all flexible bodies of a system at once: run, see what is missed, enrich, run again."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from supple.body.full_body import FullBody
from supple.correction.correction_rounds import (
    CorrectedSystem,
    ReductionStart,
    Round,
    SelfCorrected,
    SelfCorrection,
    SelfCorrectionError,
)
from supple.correction.residual_correction import system_corrections
from supple.correction.round_archive import MissedMotion, RoundArchive, RoundBases
from supple.correction.run_distance import largest_displacement, largest_distance
from supple.errors import ConvergenceError, LockingWarning
from supple.integrate import Run, Solution
from supple.machine.system import Placed, System
from supple.multibody.checks.load_spectrum import warn_of_missing_modes
from supple.reduction import ReducedBody, enrich, project, reduction_basis

__all__ = ["Announce", "CorrectionProgress", "Problem", "correct"]

Announce = Callable[[Round], None]
"""Called with every round as it is finished; of several bodies one after the other."""
CorrectionProgress = Callable[[str, float], None]
"""Called with the step at work, in words, and the completed fraction of it, 0 to 1."""


def _with_reduced(system: System, runs: Mapping[str, ReducedBody], bases: RoundBases) -> System:
    """The system with its full bodies replaced, their initial deformation projected on the bases."""
    fulls = system.bodies_of(FullBody)

    def reduced(placed: Placed) -> Placed:
        name = placed.body.name
        if name not in runs:
            return placed
        onto = bases.bases[name].vectors.T @ fulls[name].body.mass
        return replace(
            placed,
            body=runs[name],
            coordinates=onto @ placed.coordinates,
            coordinate_rates=onto @ placed.coordinate_rates,
        )

    return replace(system, bodies=tuple(reduced(placed) for placed in system.bodies))


@dataclass(frozen=True, eq=False)
class Problem:
    """All that stays the same from round to round.

    system : System         with its full bodies
    fulls, starts : by body
    run : of every round
    announce, progress, archive : as for `self_correct`
    """

    system: System
    fulls: Mapping[str, FullBody]
    starts: Mapping[str, ReductionStart]
    run: Run
    announce: Announce | None
    progress: CorrectionProgress | None
    archive: RoundArchive

    def report(self, step: str, fraction: float) -> None:
        """Say how far a step has come."""
        if self.progress is not None:
            self.progress(step, fraction)

    def target(self, name: str) -> SelfCorrection:
        """The error to reach for a body."""
        return self.starts[name].target


@dataclass(frozen=True, eq=False)
class _Model:
    """The system reduced to the bases of one round."""

    number: int
    bases: RoundBases
    bodies: Mapping[str, ReducedBody]
    system: System
    seconds: float

    @property
    def label(self) -> str:
        """What reports call it."""
        sizes = " + ".join(str(body.r) for body in self.bodies.values())
        return f"round {self.number}, {sizes} coordinates"


@dataclass(frozen=True, eq=False)
class _Run:
    model: _Model
    solution: Solution
    complete: bool
    seconds: float


@dataclass(frozen=True, eq=False)
class _Judged:
    """A round of one body, its distance from the next run, and whether it meets the target."""

    round: Round
    difference: float
    met: bool


def correct(problem: Problem) -> CorrectedSystem:
    """Round by round, until every body meets its target in the same one."""
    past: dict[str, list[_Judged]] = {name: [] for name in problem.fulls}
    first = _reduced(problem, 0, problem.archive.read_bases(0, problem.fulls) or _first_bases(problem))
    _look_at_loads(problem, first)
    current = _simulated(problem, first)
    while True:
        number = current.model.number + 1
        bases = problem.archive.read_bases(number, problem.fulls) or _enriched(problem, current)
        finer = _simulated(problem, _reduced(problem, number, bases))
        for name, judged in past.items():
            judged.append(_judge(problem.target(name), name, judged, current, finer))
            if problem.announce is not None:
                problem.announce(judged[-1].round)
        if all(judged[-1].met for judged in past.values()):
            return _result(past, current, finer)
        _check_prospects(problem, past, finer.model)
        current = finer


def _first_bases(problem: Problem) -> RoundBases:
    bases = {}
    for name, full in problem.fulls.items():
        step = f"reducing body '{name}' ({full.n_coordinates} freedoms)"
        problem.report(step, 0.0)
        start = problem.starts[name]
        bases[name] = reduction_basis(full.body, full.frame, start.basis, derivatives=start.derivatives)
        problem.report(step, 1.0)
    return RoundBases(bases)


def _reduced(problem: Problem, number: int, bases: RoundBases) -> _Model:
    began = perf_counter()
    problem.archive.keep_bases(number, bases)
    with warnings.catch_warnings():
        # What locks is missed motion like any other: the rounds find it and say what is left.
        warnings.simplefilter("ignore", LockingWarning)
        bodies = {
            name: project(
                full.body, bases.bases[name], damping=full.damping, quartic=problem.starts[name].quartic
            )
            for name, full in problem.fulls.items()
        }
    system = _with_reduced(problem.system, bodies, bases)
    return _Model(number, bases, bodies, system, perf_counter() - began)


def _look_at_loads(problem: Problem, model: _Model) -> None:
    times = problem.run.times
    for name, full in problem.fulls.items():
        warn_of_missing_modes(model.system, times, full.body, model.bodies[name])


def _simulated(problem: Problem, model: _Model) -> _Run:
    """The run; where it breaks off, as that of a start without derivatives may, it shows what it lacks."""
    began = perf_counter()
    step = f"{model.label}: simulating"
    problem.report(step, 0.0)
    solution = problem.archive.simulate(
        model.number, model.system, problem.run, progress=lambda fraction: problem.report(step, fraction)
    )
    if solution.stopped is not None and len(solution.times) < 2:
        raise ConvergenceError(solution.stopped)
    seconds = model.seconds + perf_counter() - began
    return _Run(model, solution, solution.stopped is None, seconds)


def _enriched(problem: Problem, run: _Run) -> RoundBases:
    """The bases of the next run, and what this one said."""
    began = perf_counter()
    model = run.model
    step = f"{model.label}: what they miss"
    problem.report(step, 0.0)
    instants = max(problem.target(name).instants for name in problem.fulls)
    missed = system_corrections(
        model.system,
        tuple(problem.fulls.values()),
        model.bases.bases,
        run.solution,
        _evenly_spread(len(run.solution.times), instants),
        progress=lambda fraction: problem.report(step, fraction),
    )
    bases, said = {}, {}
    for name, full in problem.fulls.items():
        enriched = enrich(
            full.body, model.bases.bases[name], missed[name].deformation, problem.target(name).directions
        )
        bases[name] = enriched.basis
        said[name] = MissedMotion(float(missed[name].rms.max()), enriched.singular_values)
    return RoundBases(bases, said, run.seconds + perf_counter() - began)


def _judge(target: SelfCorrection, name: str, before: list[_Judged], run: _Run, finer: _Run) -> _Judged:
    """Measure a run by the next one."""
    body, motion = run.model.bodies[name], run.solution.bodies[name]
    difference = np.inf
    if run.complete and finer.complete:
        difference = largest_distance(body, motion, finer.model.bodies[name], finer.solution.bodies[name])
    error = _extrapolated(difference, before[-1].difference if before else np.inf)
    if any(each.met for each in before) and not np.isfinite(error):
        # Converged as far as the time integration goes: differences at its floor shrink no more.
        error = difference
    missed = finer.model.bases.missed[name]
    allowed = target.allowed(largest_displacement(body, motion))
    # The first round has no rate of convergence to go by: there the missing motion must agree.
    doubt = missed.indicator if not before else 0.0
    return _Judged(
        Round(
            body=body,
            solution=run.solution,
            estimated_error=error,
            indicator=missed.indicator,
            singular_values=missed.singular_values,
            seconds=finer.model.bases.seconds,
            allowed=allowed,
        ),
        difference,
        max(error, doubt) <= allowed,
    )


def _result(past: Mapping[str, list[_Judged]], run: _Run, finer: _Run) -> CorrectedSystem:
    return CorrectedSystem(
        run.model.system,
        {
            name: SelfCorrected(
                tuple(each.round for each in judged), finer.model.bodies[name], finer.solution
            )
            for name, judged in past.items()
        },
    )


def _evenly_spread(n_times: int, n: int) -> np.ndarray:
    """Numbers of n output times up to the last, the start left out."""
    return np.unique(np.linspace(0, n_times - 1, n + 1).round().astype(int))[1:]


def _extrapolated(difference: float, last_difference: float) -> float:
    """All differences to come if each shrinks as the last one did; at right angles, as new columns are."""
    if not np.isfinite(difference) or difference >= last_difference:
        return np.inf
    return difference / float(np.sqrt(1 - (difference / last_difference) ** 2))


def _check_prospects(problem: Problem, past: Mapping[str, list[_Judged]], finer: _Model) -> None:
    """SelfCorrectionError when the next round would be one too many, or too large."""
    allowed_rounds = max(problem.target(name).max_rounds for name in past)
    unmet = [name for name, judged in past.items() if not judged[-1].met]
    too_large = [name for name in unmet if finer.bodies[name].r > problem.target(name).largest_size]
    if too_large:
        name = too_large[0]
        reason = (
            f"the next basis would have {finer.bodies[name].r} coordinates, more than "
            f"{problem.target(name).largest_size} allowed"
        )
    elif finer.number > allowed_rounds:
        reason = f"{allowed_rounds} rounds are over"
    else:
        return
    said = []
    for name in too_large or unmet:
        history = ", ".join(
            f"{each.round.estimated_error:.2g} with {each.round.size} coordinates" for each in past[name]
        )
        said.append(
            f"self-correction of body '{name}' did not reach the error {problem.target(name).wanted}: "
            f"{reason}. Estimated errors: {history}. "
        )
    raise SelfCorrectionError(
        "".join(said) + "Start with more modes (all those in the band of the loads), add more directions a "
        "round, tighten the tolerances of the time integration, or allow more; the rounds are kept in this "
        "error",
        tuple(each.round for judged in past.values() for each in judged),
    )
