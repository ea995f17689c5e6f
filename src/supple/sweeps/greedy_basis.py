"""Bases for the cases of a sweep, and their certificate, from full estimates of greedily chosen cases.

Some cases of a group are simulated first. The error of the case with the largest motion is estimated in full.
If this error exceeds the accuracy, the bases are enriched for this case, and the search starts again.
Otherwise the motion that the bases lack gives columns of an indicator, which estimates the errors of all
cases. The next representative case is that with the largest estimate. If this case has a full estimate
already, the second representative is the case with the smallest estimate instead. After the second, the
search then ends, unless the estimate of another case exceeds the allowed error
(docs/theory/greedy_certification.md).
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from supple.body import FullBody
from supple.error import (
    ErrorIndicator,
    ErrorStudy,
    IndicatorBody,
    SelfCorrectionError,
    case_indicators,
    indicator_body,
    size_of_motion,
)
from supple.error.basis_part import assessed_basis
from supple.error.error_estimate import INSTANTS
from supple.error.error_study import statements
from supple.error.round_archive import InMemoryArchive, RoundBases
from supple.error.start_deformation import with_start
from supple.error.system_correction import Problem, correct
from supple.errors import LockingWarning
from supple.integrate import FloatingMotion, Solution, Validity
from supple.machine import System
from supple.quantities.quantity_of_interest import WholeBody
from supple.reduction import CondensedQuartic, PlainQuartic, ReducedBody, ReductionBasis, project
from supple.simulation.stored_basis import stored_bases
from supple.sweeps.certificate import Certificate, Representative
from supple.sweeps.plan import MARCHED_AT_ONCE, SweepPlan
from supple.sweeps.swept_group import SweptCase, SweptGroup, TrainingRuns

FEWEST, MOST, MOST_EXCEEDING = 2, 3, 6
"""Smallest and largest number of representative cases of a group, and the largest number if estimates exceed
allowed errors: a full estimate costs less than a needless enrichment."""
MOST_ENRICHED = 3
"""Largest number of enrichments of the bases at representative cases."""


def certify(
    group: SweptGroup, cases: Sequence[int], first: int | None = None, runs: TrainingRuns | None = None
) -> tuple[SweptGroup, Certificate]:
    """The group with bases enriched for the representative cases that require it, and its certificate.

    cases : some cases of the group, which are simulated first
    first : the first representative, one of these cases; None: the case with the largest motion
    runs : the training runs of the cases with the bases of the group, if known
    Raises SuppleError for machines whose errors cannot be estimated, and errors of their runs.
    """
    for _ in range(MOST_ENRICHED):
        search = _Search(group, runs or group.training_runs(cases))
        exceeding = search.run(first, may_enrich=bool(group.fresh.starts))
        if exceeding is None:
            return group, search.certificate
        group, runs = _enriched(group, exceeding), None
    search = _Search(group, group.training_runs(cases))
    search.run(first, may_enrich=False)
    return group, search.certificate


def training_cases(plan: SweepPlan, cases: Sequence[int]) -> list[int]:
    """The cases of a group to simulate first: those with extreme parameters, and evenly spaced ones."""
    if len(cases) <= MARCHED_AT_ONCE:
        return list(cases)
    extremes = dict.fromkeys(
        cases[int(place)]
        for column in plan.table.columns.values()
        if isinstance(column[0], int | float) and np.ptp(own := np.array([column[case] for case in cases]))
        for place in (own.argmin(), own.argmax())
    )
    first = list(extremes)[: MARCHED_AT_ONCE // 2]
    between = np.linspace(0, len(cases) - 1, MARCHED_AT_ONCE - len(first)).round().astype(int)
    return sorted({*first, *(cases[place] for place in between.tolist())})


def indicated(
    group: SweptGroup,
    cases: Sequence[SweptCase],
    solutions: Sequence[Solution],
    bodies: Mapping[str, IndicatorBody],
) -> list[dict[str, ErrorIndicator]]:
    """Error indicators of the runs of some cases of a group, by body."""
    return case_indicators(
        [own.system for own in cases],
        cases[0].run,
        solutions,
        bodies,
        [group.dampings(own.case) for own in cases],
        at_rest=cases[0].case.tables.simulation.start == "equilibrium",
    )


class _Search:
    """Search for the representative cases of a group, with their full estimates and the certificate."""

    def __init__(self, group: SweptGroup, runs: TrainingRuns) -> None:
        self._group = group
        self._numbers, self._cases, self._solutions = runs.numbers, runs.cases, runs.solutions
        self._fields: dict[str, list[np.ndarray]] = {}
        self.certificate = Certificate(targets=group.targets)

    def run(self, first: int | None, *, may_enrich: bool) -> SweptCase | None:
        """Fill the certificate; stop at a case for which the bases must be enriched, and return that case."""
        if not self._cases:
            self.certificate = replace(self.certificate, reason="no representative case ran to its end")
        place = self._first(first) if self._cases else None
        known: dict[str, ErrorIndicator] = {}
        while place is not None:
            rows, fields = self._stated(place, known)
            if may_enrich and any(self._exceeds(each) for each in rows):
                return self._cases[place]
            for name, own in fields.items():
                self._fields.setdefault(name, []).append(own)
            bodies = self._columns()
            found = indicated(self._group, self._cases, self._solutions, bodies)
            every = [
                replace(each, final=found[self._numbers.index(each.case)][each.body].error)
                for each in (*self.certificate.representatives, *rows)
            ]
            self.certificate = replace(self.certificate, bodies=bodies, representatives=every)
            place = self._next(found)
            known = {} if place is None else found[place]
        return None

    def _first(self, number: int | None) -> int:
        """Index of the case `number`; if it is None or did not run, of the case with the largest motion.

        This is the first case in which a body has its largest motion of all cases.
        """
        if number in self._numbers:
            return self._numbers.index(number)
        sizes = np.array(
            [
                [
                    size_of_motion(body, solution.motion(name, FloatingMotion))
                    for name, body in self._group.bodies.reduced.items()
                ]
                for solution in self._solutions
            ]
        )
        return int(np.argmax((sizes / np.maximum(sizes.max(axis=0), 1e-300)).max(axis=1)))

    def _exceeds(self, row: Representative) -> bool:
        allowed = self.certificate.allowed(row.body, row.size)
        return bool(np.isfinite(allowed)) and not row.basis <= allowed

    def _stated(
        self, place: int, known: Mapping[str, ErrorIndicator]
    ) -> tuple[list[Representative], dict[str, np.ndarray]]:
        """The full estimate of a case, as for a single run, and the motion that its bases lack, by body.

        known : previous indicators of the case
        """
        own, solution = self._cases[place], self._solutions[place]
        fulls = self._group.fulls(own.case)
        bases = stored_bases(own.system, fulls)
        system = _with_locking(own.system, fulls, bases)
        quantities = [WholeBody(name) for name in bases]
        instants = max((target.instants for target in self.certificate.targets.values()), default=INSTANTS)
        whole = self._group.in_full(own.case, fulls)
        parts, fields = assessed_basis(whole, system, own.run, solution, bases, quantities, instants=instants)
        study = ErrorStudy(integration=own.case.study.integration, model=own.case.study.model)
        stated = statements(system, own.run, solution, study, fulls, bases, parts, quantities=quantities)
        rows = []
        for name in bases:
            other = [stated[name].step, stated[name].newton, stated[name].model]
            rows.append(
                Representative(
                    case=self._numbers[place],
                    body=name,
                    basis=parts[name].value,
                    others=sum(np.nan if part is None else part.value for part in other),
                    indicator=known[name].error if name in known else np.nan,
                    final=np.nan,
                    size=size_of_motion(
                        self._group.bodies.reduced[name], solution.motion(name, FloatingMotion)
                    ),
                )
            )
        return rows, dict(fields)

    def _columns(self) -> dict[str, IndicatorBody]:
        """Columns of the indicators by body, from the motion that the bases lack in the representatives."""
        first = self._cases[0]
        fulls = self._group.fulls(first.case)
        bases = stored_bases(first.system, fulls)
        reduced = first.system.bodies_of(ReducedBody)
        return {
            name: indicator_body(
                fulls[name],
                reduced[name],
                basis,
                np.concatenate(
                    [solution.motion(name, FloatingMotion).coordinates for solution in self._solutions]
                ),
                np.hstack(self._fields[name]),
            )
            for name, basis in bases.items()
        }

    def _next(self, found: Sequence[Mapping[str, ErrorIndicator]]) -> int | None:
        """Index of the next representative; None ends the search.

        The second representative is the case with the largest scaled indicator. If that case has a full
        estimate, the second is the case with the smallest scaled indicator, which shows the spread. A later
        one is the case without a full estimate that has the largest scaled indicator: the third if no case
        with a full estimate has a larger one, and any up to `MOST_EXCEEDING` if it exceeds the allowed error.
        """
        stated = {each.case for each in self.certificate.representatives}
        errors = [self.certificate.scaled_indicator(own) for own in found]
        weights = [each.basis / (each.allowed if each.allowed > 0 else 1.0) for each in errors]
        in_order = np.argsort(weights)[::-1].tolist()
        others = [int(place) for place in in_order if self._numbers[place] not in stated]
        if not others:
            return None
        is_largest = others[0] == in_order[0]
        if len(stated) < FEWEST:
            return others[0] if is_largest else others[-1]
        exceeds = errors[others[0]].ratio > 1
        if (is_largest and len(stated) < MOST) or (exceeds and len(stated) < MOST_EXCEEDING):
            return others[0]
        return None


def _with_locking(
    system: System, fulls: Mapping[str, FullBody], bases: Mapping[str, ReductionBasis]
) -> System:
    """The machine with the locking indicator in the report of each nonlinear body, computed where missing."""
    bodies = []
    for each in system.bodies:
        placed, body = each, cast("ReducedBody", each.body)
        if body.name in bases and body.report.locking is None and not fulls[body.name].body.is_linear:
            quartic = PlainQuartic() if body.condensed is None else CondensedQuartic()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", LockingWarning)
                again = project(fulls[body.name].body, bases[body.name], quartic=quartic)
            placed = replace(placed, body=replace(body, report=again.report))
        bodies.append(placed)
    return replace(system, bodies=tuple(bodies))


class _LastBases(InMemoryArchive):
    """Archive of the last bases of the rounds: those enriched with the motion that the last run lacked."""

    bases: Mapping[str, ReductionBasis]

    def keep_bases(self, number: int, bases: RoundBases) -> None:  # noqa: ARG002
        """Store the bases of a round in place of earlier ones."""
        self.bases = bases.bases


def _enriched(group: SweptGroup, own: SweptCase) -> SweptGroup:
    """The group with bases enriched until a case meets its accuracy, or for the largest number of rounds."""
    case, starts = own.case, group.fresh.starts
    fulls = group.fulls(case)
    correctable = {name: fulls[name] for name in starts}
    whole = group.in_full(case, correctable)
    bases = stored_bases(own.system, correctable)
    first = {name: with_start(whole.placed(name), full, bases[name]) for name, full in correctable.items()}
    archive = _LastBases()
    problem = Problem(
        system=whole,
        fulls=correctable,
        starts=starts,
        run=replace(own.run, validity=Validity()),
        announce=None,
        progress=None,
        archive=archive,
        first=RoundBases(first),
    )
    try:
        corrected = correct(problem)
    except SelfCorrectionError:
        found = archive.bases
    else:
        found = {name: each.basis for name, each in corrected.bodies.items()}
    return group.with_bodies({name: group.projected(name, basis) for name, basis in found.items()})
