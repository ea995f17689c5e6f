"""Self-correction with a target for the sum of errors: basis, time step, Newton's tolerance and model.

The rounds reduce the error of the basis at the given steps. Two more runs of the accepted bodies then measure
the errors of step and Newton's tolerance; the error of the model is estimated (`model_error`). If the sum
exceeds the target, the parts are reduced one by one, the cheapest first: a tighter tolerance costs
iterations, a shorter step costs steps, a smaller error of the basis costs rounds and coordinates. The
difference between the allowed error and the error of the model, times `ROOM`, is divided into shares; no part
is reduced below its share. As soon as the sum is small enough, the remaining parts stay unchanged. The next
pass starts from the existing bases; if no other part changes, these are enriched first. No run can reduce the
error of the model: if it exceeds `ROOM` times the allowed error, SelfCorrectionError is raised. Above
`HOPELESS` times the allowed error, this happens after the first run.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from supple.error.basis_error import ASK_FOR_LESS
from supple.error.correction_rounds import CorrectedSystem, Round, SelfCorrected, SelfCorrectionError
from supple.error.error_study import ErrorStudy, quantities_of_interest, statements
from supple.error.integration_error import TIGHTEST, with_shorter_steps, with_tolerance
from supple.error.model_error import model_errors
from supple.error.round_archive import RoundBases
from supple.error.system_correction import Problem, correct
from supple.errors import StepCutWarning
from supple.integrate import ErrorPart, ErrorStatement, Run, Solution
from supple.machine import System

SHARES = {"newton": 0.1, "step": 0.4, "basis": 0.5}
"""Shares of the parts in `ROOM` times (allowed error - error of the model), the cheapest part first."""
ROOM = 0.8
"""Safety factor on the target of the sum, so that one reduction is enough."""
HOPELESS = 2.0
"""Ratio of the error of the model in a first run to the allowed error; a larger one is final."""
SHORTEST = 1 / 8
"""Smallest factor on the step in one pass; errors that fall more slowly than h^2 take several passes."""
PASSES = 6
MANY = 10
"""Smallest ratio of the number of steps to the given number at which a warning is issued."""


@dataclass(frozen=True)
class _Reductions:
    """Changes for the next pass: factors (1: no change), and a reserve (None: no change of the basis)."""

    tolerance: float = 1.0
    step: float = 1.0
    basis: float | None = None
    """Part of the allowed error reserved for errors other than that of the basis."""


def correct_wholly(problem: Problem, study: ErrorStudy) -> CorrectedSystem:
    """Repeat passes, each with rounds as in `correct`, until the sum of all parts is allowed for every body.

    Raises
    ------
    SelfCorrectionError     the error of the model alone is too large; the sum is too large after `PASSES`
                            passes, or a further pass would repeat the last one. Its `rounds` are those of all
                            passes; an error raised by `correct` has the rounds of its own pass only
    """
    problem = replace(
        problem,
        simulated=lambda system, bases, solution: _check_first_run(problem, study, system, bases, solution),
    )
    before: dict[str, tuple[Round, ...]] = {name: () for name in problem.fulls}
    unmet: dict[str, ErrorStatement] = {}
    attempt, asked_run = 0, problem.run
    for attempt in range(PASSES):
        corrected = _with_rounds(correct(problem), before)
        before = {name: own.rounds for name, own in corrected.bodies.items()}
        if problem.accepted is not None:
            problem.accepted(corrected)
        stated = _stated(problem, corrected, study)
        solution = corrected.solution.with_errors(stated)
        corrected = _with_solution(corrected, solution, problem.run)
        asked = {name: stated[problem.target(name).quantity(name).name] for name in problem.fulls}
        unmet = {name: each for name, each in asked.items() if not each.is_met}
        if not unmet:
            return corrected
        _check_model(unmet, before)
        following = _next_pass(problem, corrected, unmet)
        if attempt == PASSES - 1 or _is_same(following, problem):
            break
        _announce_steps(asked_run, problem, following)
        problem = following
    raise SelfCorrectionError(
        " ".join(
            f"self-correction of body '{name}' did not reach the error {problem.target(name).wanted} in "
            f"{attempt + 1} passes: estimated {each.at_least:.2g}, allowed {each.allowed:.2g}; parts: "
            f"{_words(each)}; {each.advice}."
            for name, each in unmet.items()
        )
        + " The rounds are in the attribute `rounds` of this error",
        tuple(each for own in before.values() for each in own),
    )


def _stated(problem: Problem, corrected: CorrectedSystem, study: ErrorStudy) -> dict[str, ErrorStatement]:
    """Error statements of the target quantity of every body, and of further quantities."""
    system, solution = corrected.system, corrected.solution
    of_basis: dict[str, ErrorPart] = dict(corrected.of_basis)
    allowed: dict[str, float] = {}
    for name, own in corrected.bodies.items():
        quantity = problem.target(name).quantity(name)
        last = own.rounds[-1]
        of_basis[quantity.name] = ErrorPart(last.estimated_error, "the error equation", ASK_FOR_LESS)
        allowed[quantity.name] = last.allowed
    targets = [problem.target(name).quantity(name) for name in corrected.bodies]
    others = [each for each in quantities_of_interest(system, study) if each.name not in allowed]
    bases = {name: own.basis for name, own in corrected.bodies.items()}
    return statements(
        system,
        problem.run,
        solution,
        study,
        problem.fulls,
        bases,
        of_basis,
        allowed=allowed,
        quantities=[*targets, *others],
        progress=problem.report,
    )


def _with_rounds(corrected: CorrectedSystem, before: Mapping[str, tuple[Round, ...]]) -> CorrectedSystem:
    bodies = {
        name: replace(own, rounds=(*before[name], *own.rounds)) for name, own in corrected.bodies.items()
    }
    return replace(corrected, bodies=bodies)


def _with_solution(corrected: CorrectedSystem, solution: Solution, run: Run) -> CorrectedSystem:
    """The corrected system with this solution in the last round of every body, and with this run."""

    def assessed_rounds(own: SelfCorrected) -> SelfCorrected:
        return replace(own, rounds=(*own.rounds[:-1], replace(own.rounds[-1], solution=solution)))

    bodies = {name: assessed_rounds(own) for name, own in corrected.bodies.items()}
    return replace(corrected, bodies=bodies, run=run)


def _next_pass(problem: Problem, corrected: CorrectedSystem, unmet: Mapping[str, ErrorStatement]) -> Problem:
    """The next pass: from the current bases, with the changes that unmet bodies need."""
    needs = {name: _needed(each) for name, each in unmet.items()}
    run = problem.run
    tolerance = min(each.tolerance for each in needs.values())
    if tolerance < 1:
        # Rounded down to a power of ten; finer graduation has no use.
        decade = np.floor(np.log10(tolerance * run.tolerances.residual) + 1e-9)
        run = with_tolerance(run, max(float(f"1e{decade:.0f}"), TIGHTEST))
    step = min(each.step for each in needs.values())
    if step < 1:
        run = with_shorter_steps(run, step)
    spent = dict(problem.spent) | {name: each.basis for name, each in needs.items() if each.basis is not None}
    # With unchanged steps the first round would estimate the known errors again. With others, its missing
    # motion is that of the new steps, which improves a basis more.
    same = tolerance == step == 1
    reached = {
        name: own.next_basis if same and needs.get(name, _Reductions()).basis is not None else own.basis
        for name, own in corrected.bodies.items()
    }
    last = max(own.rounds[-1].number or 0 for own in corrected.bodies.values())
    return replace(
        problem,
        run=run,
        spent=spent,
        first=RoundBases(reached),
        number=last + 2,  # last + 1: bases are stored, and the run that confirms them, if any
        confirmed=problem.confirmed
        | {name for name, own in corrected.bodies.items() if not own.rounds[-1].unconfirmed},
    )


def _announce_steps(asked: Run, problem: Problem, following: Problem) -> None:
    """Report the number of steps before a pass; warn from `MANY` times the given number on."""
    before, after, wanted = (round(each.n_steps) for each in (problem.run, following.run, asked))
    if after == before:
        return
    words = f"{after} steps of at most {following.run.step_control.largest:.3g} instead of {before}"
    problem.report(f"the error of the time step is too large: {words}", 0.0)
    if after >= MANY * wanted > before:
        warnings.warn(
            f"self-correction needs {after} steps of at most {following.run.step_control.largest:.3g} "
            f"instead of {wanted}, so that each run takes {after / wanted:.0f} times as long: allow a larger "
            "error, or take adaptive steps",
            StepCutWarning,
            stacklevel=4,
        )


def _is_same(following: Problem, problem: Problem) -> bool:
    """Whether a pass would repeat the last one: equal reserves, tolerances and steps."""
    one, other = following.run, problem.run
    return (
        following.spent == problem.spent
        and one.tolerances == other.tolerances
        and one.step_control == other.step_control
    )


def _needed(stated: ErrorStatement) -> _Reductions:
    """Reductions that bring the sum below the allowed error; cheapest parts first, none below its share."""
    allowed = stated.allowed or 0.0
    values = {name: part.value for name, part in stated.parts.items() if name in SHARES}
    left = ROOM * (allowed - (0.0 if stated.model is None else stated.model.value))
    brought = dict(values)
    for name, share in SHARES.items():
        if sum(brought.values()) <= left or name not in values:
            continue
        rest = left - sum(value for key, value in brought.items() if key != name)
        brought[name] = min(values[name], max(rest, share * left))
    step = 1.0
    if brought.get("step", 0.0) < values.get("step", 0.0):
        ratio = brought["step"] / values["step"] if np.isfinite(values["step"]) else 0.0
        step = max(float(np.sqrt(ratio)), SHORTEST)
    tolerance = 1.0
    if brought.get("newton", 0.0) < values.get("newton", 0.0):
        tolerance = max(brought["newton"] / values["newton"], 1e-3)
    basis = None
    if brought.get("basis", 0.0) < values.get("basis", 0.0):
        basis = allowed - brought["basis"]
    return _Reductions(tolerance, step, basis)


def _check_first_run(
    problem: Problem, study: ErrorStudy, system: System, bases: RoundBases, solution: Solution
) -> None:
    """Raise SelfCorrectionError where the kinematics alone exceed the target, before the rounds are computed.

    The kinematics are assessed at the largest rotation. The basis of a first run may be poor: only an error
    above `HOPELESS` times the allowed one ends the self-correction.
    """
    if not study.model:
        return
    quantities = {name: problem.target(name).quantity(name) for name in problem.fulls}
    found = model_errors(system, problem.fulls, bases.bases, solution, list(quantities.values()), instants=1)
    for name, quantity in quantities.items():
        allowed = problem.target(name).allowed(quantity.size(system, solution))
        if found[quantity.name].value > HOPELESS * allowed:
            raise SelfCorrectionError(_beyond_kinematics(name, found[quantity.name], allowed), ())


def _beyond_kinematics(name: str, model: ErrorPart, allowed: float) -> str:
    return (
        f"self-correction of body '{name}': the error of its kinematics alone is {model.value:.2g}, and the "
        f"allowed sum of errors is {allowed:.2g}; no basis or step reduces it: {model.remedy}, or allow a "
        "larger error"
    )


def _check_model(unmet: Mapping[str, ErrorStatement], rounds: Mapping[str, tuple[Round, ...]]) -> None:
    for name, each in unmet.items():
        if each.model is not None and each.allowed is not None and each.model.value > ROOM * each.allowed:
            raise SelfCorrectionError(
                f"{_beyond_kinematics(name, each.model, each.allowed)}. The rounds are in the attribute "
                "`rounds` of this error",
                tuple(one for own in rounds.values() for one in own),
            )


def _words(stated: ErrorStatement) -> str:
    return ", ".join(f"{name} {part.value:.2g}" for name, part in stated.parts.items())
