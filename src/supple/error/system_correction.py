"""Self-correction of reduced bodies: simulate, estimate the motion outside their bases, enrich, repeat."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from supple.body.full_body import FullBody
from supple.equations.checks.load_spectrum import warn_of_missing_modes
from supple.error.basis_error import ASK_FOR_LESS, FIRST_ORDER
from supple.error.basis_part import distances, stated_of
from supple.error.correction_rounds import (
    CorrectedSystem,
    ReductionStart,
    Round,
    SelfCorrected,
    SelfCorrection,
    SelfCorrectionError,
)
from supple.error.error_estimate import ErrorEstimate, ErrorEstimator
from supple.error.round_archive import MissedMotion, RoundArchive, RoundBases
from supple.error.start_deformation import with_reduced, with_start
from supple.error.stopping import doubt, is_confirmed, is_useless, missed_part
from supple.errors import ConvergenceError, LockingWarning
from supple.integrate import ErrorPart, Run, Solution, StepProgress
from supple.machine.system import System
from supple.quantities.quantity_of_interest import QuantityOfInterest, WholeBody, quantity_distance
from supple.reduction import ReducedBody, enrich, padded, project, reduction_basis
from supple.reduction.tensors import require_tensor_memory

Announce = Callable[[Round], None]
"""Called with every finished round; with several bodies, once per body."""

Accepted = Callable[[CorrectedSystem], None]
"""Called with the run whose basis meets the target, before other parts of the error are estimated."""

Simulated = Callable[[System, RoundBases, Solution], None]
"""Called with the very first run, if it is complete, before its error is estimated."""

MOST_PADDED_STEPS = 20_000
"""Largest number of steps of a run with padding coordinates (`padded`). Padding lets rounds share a compiled
program; in longer runs it costs more time than another compilation."""


@dataclass(frozen=True, eq=False)
class Problem:
    """The data of a self-correction that stay the same from round to round.

    system : System         with its full bodies
    fulls, starts : full bodies, and starts of their reductions, by body
    run : settings of every round
    announce, accepted, progress, archive : as for `self_correct`
    first : bases of the first run, from an earlier pass of `correct_wholly`; None: those of `starts`
    number : number of the first run in the archive
    spent : part of the allowed error reserved for errors other than that of the basis, by body
    confirmed : bodies whose estimates an earlier pass has confirmed
    besides : further quantities of interest for which the error of the accepted run is stated
    simulated : as `Simulated`
    """

    system: System
    fulls: Mapping[str, FullBody]
    starts: Mapping[str, ReductionStart]
    run: Run
    announce: Announce | None
    progress: StepProgress | None
    archive: RoundArchive
    first: RoundBases | None = None
    number: int = 0
    spent: Mapping[str, float] = field(default_factory=dict)
    accepted: Accepted | None = None
    confirmed: frozenset[str] = frozenset()
    besides: tuple[QuantityOfInterest, ...] = ()
    simulated: Simulated | None = None

    def report(self, step: str, fraction: float) -> None:
        """Report the completed fraction of a step."""
        if self.progress is not None:
            self.progress(step, fraction)

    def target(self, name: str) -> SelfCorrection:
        """The target error of a body."""
        return self.starts[name].target


@dataclass(frozen=True, eq=False)
class _Model:
    """The system reduced to the bases of one round, in short runs with padding; `bodies` have no padding."""

    number: int
    bases: RoundBases
    bodies: Mapping[str, ReducedBody]
    system: System
    seconds: float

    @property
    def label(self) -> str:
        """Name of the round in progress reports."""
        sizes = " + ".join(str(body.r) for body in self.bodies.values())
        return f"round {self.number}, {sizes} coordinates"


@dataclass(frozen=True, eq=False)
class _Run:
    model: _Model
    solution: Solution
    complete: bool
    seconds: float


@dataclass(frozen=True, eq=False)
class _Assessed:
    """A round of one body; `allowed`: its estimated error meets the target, but may be unconfirmed."""

    round: Round
    allowed: bool

    @property
    def met(self) -> bool:
        """Whether the round meets the target."""
        return self.allowed and not self.round.unconfirmed

    def confirmed(self, confirmed: bool) -> _Assessed:
        """The round, with its error confirmed if two runs agree."""
        unconfirmed = self.round.unconfirmed and not confirmed
        return replace(self, round=replace(self.round, unconfirmed=unconfirmed))


def correct(problem: Problem) -> CorrectedSystem:
    """Repeat rounds until every body meets its target in the same round."""
    for name, full in problem.fulls.items():
        require_tensor_memory(
            full.body,
            problem.target(name).largest_size,
            strain_rate_damping=full.damping is not None and bool(full.damping.retardation_time),
            named="as largest_size",
        )
    past: dict[str, list[_Assessed]] = {name: [] for name in problem.fulls}
    estimator = ErrorEstimator(problem.system, problem.run)
    before: _Run | None = None
    kept = problem.archive.read_bases(problem.number, problem.fulls)
    next_bases = kept or problem.first or _first_bases(problem)
    model = _reduced(problem, problem.number, next_bases)
    _check_load_band(problem, model, estimator)
    while True:
        run = _simulated(problem, model)
        if problem.simulated is not None and model.number == 0 and run.complete:
            problem.simulated(run.model.system, run.model.bases, run.solution)
        allowed = {name: _allowed(problem, name, run) for name in problem.fulls}
        agree = {name: _agree(problem, name, past[name], before, run, allowed[name]) for name in past}
        if before is not None and _awaits_second_run(past):
            for name, own in past.items():
                own[-1] = own[-1].confirmed(agree[name])
            _announce(problem, past)
            if _is_met(past):
                return _result(past, before, next_bases)
            _check_prospects(problem, past, model.number, next_bases)
        kept = problem.archive.read_bases(model.number + 1, problem.fulls)
        next_bases = kept or _enriched(problem, estimator, run, allowed, first=before is None)
        for name, own in past.items():
            own.append(_assess(problem, name, own, run, next_bases, allowed[name], agree[name]))
        if not _awaits_second_run(past):
            _announce(problem, past)
            if _is_met(past):
                return _result(past, run, next_bases)
            _check_prospects(problem, past, model.number + 1, next_bases)
        before = run
        model = _reduced(problem, model.number + 1, next_bases)


def _is_met(past: Mapping[str, list[_Assessed]]) -> bool:
    """Whether every body meets its target in the last round."""
    return all(own[-1].met for own in past.values())


def _awaits_second_run(past: Mapping[str, list[_Assessed]]) -> bool:
    """Whether all errors of the last round are allowed and a second run can confirm those in doubt."""
    return all(own and own[-1].allowed for own in past.values()) and not _is_met(past)


def _announce(problem: Problem, past: Mapping[str, list[_Assessed]]) -> None:
    if problem.announce is not None:
        for own in past.values():
            problem.announce(own[-1].round)


def _first_bases(problem: Problem) -> RoundBases:
    bases = {}
    for name, full in problem.fulls.items():
        step = f"reducing body '{name}' ({full.n_coordinates} degrees of freedom)"
        problem.report(step, 0.0)
        start = problem.starts[name]
        basis = reduction_basis(full.body, full.frame, start.basis, derivatives=start.derivatives)
        bases[name] = with_start(problem.system.placed(name), full, basis)
        problem.report(step, 1.0)
    return RoundBases(bases)


def _reduced(problem: Problem, number: int, bases: RoundBases) -> _Model:
    began = perf_counter()
    problem.archive.keep_bases(number, bases)
    with warnings.catch_warnings():
        # No warning of locking: the rounds find and report the motion outside the basis that causes it.
        warnings.simplefilter("ignore", LockingWarning)
        bodies = {
            name: project(
                full.body, bases.bases[name], damping=full.damping, quartic=problem.starts[name].quartic
            )
            for name, full in problem.fulls.items()
        }
    brief = problem.run.n_steps <= MOST_PADDED_STEPS
    ready = {name: padded(body) for name, body in bodies.items()} if brief else bodies
    system = with_reduced(problem.system, ready, bases.bases)
    return _Model(number, bases, bodies, system, perf_counter() - began)


def _check_load_band(problem: Problem, model: _Model, estimator: ErrorEstimator) -> None:
    times = problem.run.times
    for name, full in problem.fulls.items():
        # More modes than the check needs; the check reads their frequencies from the body.
        estimator.modes(name)
        warn_of_missing_modes(model.system, times, full.body, model.bodies[name])


def _simulated(problem: Problem, model: _Model) -> _Run:
    """Simulate a round. Without modal derivatives a run may stop early; its motion until then is used."""
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


def _enriched(
    problem: Problem, estimator: ErrorEstimator, run: _Run, allowed: Mapping[str, float], *, first: bool
) -> RoundBases:
    """The bases of the next run, and the estimated errors of this one.

    In the first round of a self-correction, a motion outside the bases that exceeds the allowed error makes
    every estimate doubtful, and no earlier run can confirm it: the error is not estimated.
    """
    began = perf_counter()
    model = run.model
    step = f"{model.label}: motion outside the bases"
    problem.report(step, 0.0)
    limits = {name: _allowed_length(problem, name, run, error) for name, error in allowed.items()}
    estimate = estimator.assess(
        model.system,
        model.bases.bases,
        run.solution,
        instants=max(problem.target(name).instants for name in problem.fulls),
        largest_missing={name: limits[name] for name in limits if first and name not in problem.confirmed},
        progress=lambda fraction: problem.report(step, fraction),
    )
    bases, found = {}, {}
    for name, full in problem.fulls.items():
        enriched = enrich(
            full.body, model.bases.bases[name], estimate.missed[name], problem.target(name).directions
        )
        bases[name] = enriched.basis
        found[name] = MissedMotion(
            float(estimate.corrections[name].rms.max()),
            enriched.singular_values,
            _error(problem.target(name).quantity(name), name, run, estimate),
            estimate.error.bodies[name].is_doubtful(limits[name]),
        )
    besides: Mapping[str, float] = {}
    if all(found[name].error <= error for name, error in allowed.items()):  # possibly the last round
        asked = stated_of(model.system, problem.fulls, problem.besides)
        besides = distances(model.system, run.solution, estimate, asked)
    next_bases = RoundBases(bases, found, run.seconds + perf_counter() - began, besides)
    # Stored even if no next run follows: the errors of this run are stored with the bases of the next.
    problem.archive.keep_bases(model.number + 1, next_bases)
    return next_bases


def _allowed_length(problem: Problem, name: str, run: _Run, allowed: float) -> float:
    """Limit of the motion outside a basis: the allowed relative error times the body's displacement."""
    quantity, system = problem.target(name).quantity(name), run.model.system
    if isinstance(quantity, WholeBody):
        return allowed
    size = quantity.size(system, run.solution)
    return allowed / size * WholeBody(name).size(system, run.solution) if size else 0.0


def _error(quantity: QuantityOfInterest, name: str, run: _Run, estimate: ErrorEstimate) -> float:
    """Error of a quantity, from the corrected motion and the part outside the error space.

    Infinite without a second correction, or if the second exceeds a third of the first: then at most the
    order of magnitude is known.
    """
    own = estimate.error.bodies[name]
    if estimate.corrected is None or own.second is None or own.second > FIRST_ORDER:
        return np.inf
    difference = quantity_distance(quantity, run.model.system, run.solution, *estimate.corrected)
    return difference * (own.estimate / own.rms if own.rms else 1.0)


def _agree(
    problem: Problem, name: str, past: list[_Assessed], before: _Run | None, run: _Run, allowed: float
) -> bool:
    """Whether the distance of this run from the previous one confirms the error of the previous one.

    The previous run has fewer coordinates. In the first round: whether an earlier pass has confirmed it.
    """
    if before is None:
        return name in problem.confirmed
    estimated = past[-1].round.estimated_error
    if not np.isfinite(estimated):
        return False
    distance = quantity_distance(
        problem.target(name).quantity(name),
        before.model.system,
        before.solution,
        run.model.system,
        run.solution,
    )
    return is_confirmed(estimated, distance, allowed)


def _assess(
    problem: Problem,
    name: str,
    before: list[_Assessed],
    run: _Run,
    after: RoundBases,
    allowed: float,
    confirmed: bool,
) -> _Assessed:
    """The error of a run compared with the target; `confirmed` : whether earlier runs confirm it."""
    missed = after.missed[name]
    known = [np.inf if each.round.unconfirmed else each.round.estimated_error for each in before]
    was_met = any(each.met for each in before)
    after_useless = bool(before) and before[-1].round.useless and not was_met
    return _Assessed(
        Round(
            body=run.model.bodies[name],
            solution=run.solution,
            estimated_error=missed.error,
            indicator=missed.indicator,
            singular_values=missed.singular_values,
            seconds=after.seconds,
            allowed=allowed,
            useless=is_useless([*known, missed.error]),
            unconfirmed=missed.doubtful and not confirmed,
            number=run.model.number,
            run=problem.run,
        ),
        missed.error <= allowed - problem.spent.get(name, 0.0) and not after_useless,
    )


def _allowed(problem: Problem, name: str, run: _Run) -> float:
    """The allowed error, in the unit of the quantity of interest."""
    target = problem.target(name)
    return target.allowed(target.quantity(name).size(run.model.system, run.solution))


def _result(past: Mapping[str, list[_Assessed]], run: _Run, after: RoundBases) -> CorrectedSystem:
    return CorrectedSystem(
        run.model.system,
        {
            name: SelfCorrected(
                tuple(each.round for each in assessed), run.model.bases.bases[name], after.bases[name]
            )
            for name, assessed in past.items()
        },
        of_basis={
            name: ErrorPart(error, "the error equation", ASK_FOR_LESS)
            for name, error in after.besides.items()
        },
    )


def _check_prospects(
    problem: Problem, past: Mapping[str, list[_Assessed]], number: int, after: RoundBases
) -> None:
    """Raise SelfCorrectionError where the rounds or the allowed coordinates are used up."""
    allowed_rounds = max(problem.target(name).max_rounds for name in past)
    unmet = [name for name, assessed in past.items() if not assessed[-1].met]
    too_large = [name for name in unmet if after.bases[name].r > problem.target(name).largest_size]
    if too_large:
        name = too_large[0]
        reason = (
            f"the next basis would have {after.bases[name].r} coordinates, more than "
            f"{problem.target(name).largest_size} allowed"
        )
    elif number - problem.number > allowed_rounds:
        reason = f"all rounds are used up (max_rounds = {allowed_rounds})"
    else:
        return
    reasons = []
    for name in too_large or unmet:
        history = ", ".join(
            f"{_words(each.round.estimated_error)} with {each.round.size} coordinates" for each in past[name]
        )
        useless = [str(each.round.number) for each in past[name] if each.round.useless]
        idle = f"Round {', '.join(useless)} did not reduce the error. " if useless else ""
        last = past[name][-1].round
        if last.unconfirmed and last.estimated_error <= last.allowed:
            idle += f"No second run confirms the last error, and {doubt(last.body, last.indicator)}. "
        part = missed_part(problem.fulls[name], after.bases[name], past[name][-1].round.size)
        reasons.append(
            f"self-correction of body '{name}' did not reach the error {problem.target(name).wanted}: "
            f"{reason}. Estimated errors: {history}. {idle}{part.words}. "
        )
    raise SelfCorrectionError(
        "".join(reasons)
        + "Start with more modes (all those in the band of the loads), add more directions per "
        "round, tighten the tolerances of the time integration, or allow a larger error. The rounds are in "
        "the attribute `rounds` of this error",
        tuple(each.round for assessed in past.values() for each in assessed),
    )


def _words(error: float) -> str:
    return f"{error:.2g}" if np.isfinite(error) else "unknown"
