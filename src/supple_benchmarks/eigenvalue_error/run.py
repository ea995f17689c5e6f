"""The bodies of [Han2020] reduced to each tolerance: modes, estimates, exact errors, verification, cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from supple.body import FlexibleBody
from supple.reduction import (
    Bisection,
    CraigBamptonFamily,
    EigenvalueErrorEstimator,
    ErrorControlled,
    FirstOrderEstimate,
    Han2020Bound,
    KnownEigenvalues,
    OneByOne,
    SearchStep,
    SharperBound,
    TwoTermEstimate,
    count_eigenvalues,
    error_controlled_modes,
)
from supple_benchmarks.eigenvalue_error.basis_sizes import BasisSize, basis_sizes
from supple_benchmarks.eigenvalue_error.problem import BodyCase, EigenvalueErrors
from supple_benchmarks.progress import Announce, Progress

__all__ = [
    "BodyResult",
    "ToleranceResult",
    "run_eigenvalue_errors",
]

Array = np.ndarray

ESTIMATORS: Mapping[str, EigenvalueErrorEstimator] = {
    "lower": FirstOrderEstimate(),
    "paper": Han2020Bound(),
    "sharp": SharperBound(),
    "two_term": TwoTermEstimate(),
}


class Seconds(NamedTuple):
    """Wall and processor time of a step; the two differ if the computer has other load."""

    wall: float
    cpu: float


@dataclass(frozen=True, eq=False)
class ToleranceResult:
    """One body at one tolerance.

    modes : number of modes, by the sharper bound, verified
    estimated_modes : {estimator: number of modes}, not verified; "exact" is the number by exact errors
    exact, proven : (N,)            exact errors, and their verified bounds
    estimates : {estimator: (N,)}   with `modes` modes
    counts : number of inertia counts;   counted : whether they verify all eigenvalues
    seconds, seconds_one_by_one : the whole reduction with verification, by bisection and one mode at a time
    seconds_plain : one reduction with as many modes, without search or verification
    same_answer : whether both searches give equal numbers of modes
    steps, n_one_by_one : steps of the bisection; number of steps of the search one mode at a time
    """

    tolerance: float
    modes: int
    estimated_modes: Mapping[str, int]
    exact: Array
    proven: Array
    estimates: Mapping[str, Array]
    counts: int
    counted: bool
    seconds: Seconds
    seconds_one_by_one: Seconds
    seconds_plain: Seconds
    same_answer: bool
    steps: tuple[SearchStep, ...]
    n_one_by_one: int

    def effectivity(self, estimator: str) -> Array:
        """Estimated over exact error (N,)."""
        return self.estimates[estimator] / self.exact


@dataclass(frozen=True, eq=False)
class BodyResult:
    """One body at all tolerances.

    n, nodes, cells : numbers of degrees of freedom, nodes, tetrahedra
    exact : (N,)            eigenvalues of the full body, rad^2/s^2
    bases : number of modes of each reduction basis for the same exact errors
    """

    case: BodyCase
    n: int
    nodes: int
    cells: int
    exact: Array
    results: tuple[ToleranceResult, ...]
    bases: tuple[BasisSize, ...]


def run_eigenvalue_errors(problem: EigenvalueErrors, progress: Announce) -> Iterator[BodyResult]:
    """The results of each body, one after the other."""
    for case in problem.cases():
        yield _run_case(case, problem, progress(f"{case.name} {case.element}"))


def _run_case(case: BodyCase, problem: EigenvalueErrors, advance: Progress) -> BodyResult:
    body = case.build()
    elastic = (body.mass @ body.rigid_modes).T
    exact = body.lowest_modes(case.n_modes, elastic).values
    family = CraigBamptonFamily(body)
    results = []
    for done, tolerance in enumerate(problem.tolerances):
        results.append(_at_tolerance(body, family, exact, tolerance))
        advance((done + 1) / (len(problem.tolerances) + 1))
    sizes = basis_sizes(
        body, problem.tolerances, case.n_modes, candidates=problem.candidates, fixed_modes=family.modes
    )
    advance(1.0)
    assert body.model is not None
    cells = body.model.mesh.cells[body.model.mesh.only_cell_type()]
    return BodyResult(case, body.n, len(body.nodes), len(cells), exact, tuple(results), sizes)


def _at_tolerance(
    body: FlexibleBody, family: CraigBamptonFamily, exact: Array, tolerance: float
) -> ToleranceResult:
    n_modes, known = exact.size, KnownEigenvalues(exact)
    times = [_now()]
    reduced = error_controlled_modes(body, ErrorControlled(tolerance, n_modes)).certificate
    n_kept = reduced.n_fixed_interface_modes
    times.append(_now())
    published = error_controlled_modes(body, ErrorControlled(tolerance, n_modes, search=OneByOne()))
    times.append(_now())
    one_size = CraigBamptonFamily(body)
    one_size.vectors(one_size.vibrations(n_kept, n_modes))
    times.append(_now())
    searched, searched_one_by_one, plain = (Seconds(*row) for row in np.diff(times, axis=0).tolist())
    required = {name: _required(family, tolerance, n_modes, one) for name, one in ESTIMATORS.items()}
    counts = count_eigenvalues(body, reduced.values, tolerance)
    return ToleranceResult(
        tolerance=tolerance,
        modes=n_kept,
        estimated_modes={**required, "exact": _required(family, tolerance, n_modes, known)},
        exact=family.errors(n_kept, n_modes, known),
        proven=reduced.errors,
        estimates={name: family.errors(n_kept, n_modes, one) for name, one in ESTIMATORS.items()},
        counts=len(counts),
        counted=all(group.proven for group in counts),
        seconds=searched,
        seconds_one_by_one=searched_one_by_one,
        seconds_plain=plain,
        same_answer=published.certificate.n_fixed_interface_modes == n_kept,
        steps=reduced.steps,
        n_one_by_one=len(published.certificate.steps),
    )


def _now() -> tuple[float, float]:
    return perf_counter(), process_time()


def _required(
    family: CraigBamptonFamily, tolerance: float, n_modes: int, estimator: EigenvalueErrorEstimator
) -> int:
    def trial(n_kept: int) -> SearchStep:
        errors = family.errors(n_kept, n_modes, estimator)
        return SearchStep(n_kept, errors, tolerance, type(estimator).__name__, 0.0)

    return Bisection().run(trial, 5, family.n_available)[-1].n_modes
