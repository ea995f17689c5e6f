"""Self-correcting reduction: a reduced run finds what its basis misses, mends it, and tells its own error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from supple.algebra import read_only
from supple.body import FlexibleBody, Frame, RayleighDamping
from supple.errors import AccuracyError, ConvergenceError, ModelError
from supple.integrate import Solution, StepControl, TimeIntegrator, Tolerances, concatenate
from supple.multibody.full_body import FullBody
from supple.multibody.residual_correction import residual_corrections
from supple.multibody.simulate import simulate
from supple.multibody.system import System
from supple.multibody.validity import Validity
from supple.reduction import (
    CompressedDerivatives,
    DerivativeChoice,
    LinearBasisRecipe,
    ReducedBody,
    ReductionBasis,
    enrich,
    project,
    reduction_basis,
)

__all__ = ["Round", "SelfCorrected", "SelfCorrection", "SelfCorrectionError", "self_correct"]


@dataclass(frozen=True)
class SelfCorrection:
    """The error to reach, and how to get there.

    absolute : float        largest RMS error of the nodal positions over the run, unit of length; or
    relative : float        the same over the largest displacement of a node in its floating frame
    instants : int          output times of a run at which its residual is evaluated, evenly spread
    directions : int        columns added a round
    largest_size : int      of the basis returned; the run that measures its error has a richer one
    max_rounds : int        enrichments before giving up
    Raises ModelError when both or none of absolute and relative are given, or a number is not positive.
    """

    absolute: float | None = None
    relative: float | None = None
    instants: int = 50
    directions: int = 3
    largest_size: int = 60
    max_rounds: int = 8

    def __post_init__(self) -> None:
        if (self.absolute is None) == (self.relative is None):
            raise ModelError("self-correction: give the error to reach either as absolute or as relative")
        for name, value in vars(self).items():
            if value is not None and not (np.isfinite(value) and value > 0):
                raise ModelError(f"self-correction: {name} must be a positive number, not {value}")

    def allowed(self, largest_displacement: float) -> float:
        """The error to reach, unit of length."""
        return self.absolute or (self.relative or 0.0) * largest_displacement


@dataclass(frozen=True, eq=False)
class Round:
    """One run and what it said about its basis.

    body : ReducedBody
    solution : Solution             up to where the run broke off, if it did
    estimated_error : float         largest RMS error of the nodal positions over the run; infinite where
                                    the run, or the next one that was to measure it, broke off, or where
                                    the rounds do not converge
    indicator : float               largest RMS of the motion that the basis misses, at the instants looked at
    singular_values : (k,)          of that motion outside the basis, in the M-norm, descending
    seconds : float                 wall time of the reduction, the run and its correction
    """

    body: ReducedBody
    solution: Solution
    estimated_error: float
    indicator: float
    singular_values: np.ndarray
    seconds: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "singular_values", read_only(self.singular_values))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.body.r


@dataclass(frozen=True, eq=False)
class SelfCorrected:
    """A reduced body that meets a tolerance on a run, and the rounds that led to it.

    rounds : Round              the last one meets the tolerance
    finer_body, finer_solution  the run with the next, richer basis, by which its error was measured
    """

    rounds: tuple[Round, ...]
    finer_body: ReducedBody
    finer_solution: Solution

    @property
    def body(self) -> ReducedBody:
        """The smallest body that meets the tolerance."""
        return self.rounds[-1].body

    @property
    def solution(self) -> Solution:
        """Its run."""
        return self.rounds[-1].solution

    @property
    def estimated_error(self) -> float:
        """Error of that run, unit of length."""
        return self.rounds[-1].estimated_error


class SelfCorrectionError(AccuracyError):
    """The tolerance was not met; `rounds` keeps every run that was made and measured."""

    def __init__(self, message: str, rounds: tuple[Round, ...]) -> None:
        super().__init__(message)
        self.rounds = rounds


@dataclass(frozen=True, eq=False)
class _Run:
    system: System
    basis: ReductionBasis
    body: ReducedBody
    solution: Solution
    complete: bool
    seconds: float


def self_correct(
    system_of: Callable[[ReducedBody], System],
    body: FlexibleBody,
    frame: Frame,
    basis: LinearBasisRecipe,
    *,
    target: SelfCorrection,
    duration: float,
    output_step: float,
    derivatives: DerivativeChoice = CompressedDerivatives(5),  # noqa: B008 (it is immutable)
    damping: RayleighDamping | None = None,
    step: StepControl | None = None,
    method: TimeIntegrator | None = None,
    tolerances: Tolerances | None = None,
    validity: Validity | None = None,
    announce: Callable[[Round], None] | None = None,
) -> SelfCorrected:
    """Reduce a body as far as an error allows, which the reduced runs themselves measure.

    Start small, run, find at a few instants the motion that the basis misses (`residual_corrections`), append
    its leading directions to the basis, run again. No full-order time integration is made. Run k is measured
    by run k + 1, with eps the largest RMS distance of the nodes over the run:

        d_k = eps(run k, run k+1),   e_k = d_k / (1 - rho),   rho = d_k / d_(k-1)

    which adds up the runs to come were each of them to gain as little as the last one did; a round gains one
    to three orders, so that e_k is d_k but for a per cent, and the rounds end where d_k does not shrink. So
    the run that meets the tolerance is the last but one. The size of the missing motion (`Round.indicator`)
    is a second opinion, asked for in the first round, where rho is unknown and taken as zero: sharp for slow
    motion, loose near a resonance of what the basis lacks. Modes inside the band in which the loads excite
    the body belong in the basis from the start.

    Parameters
    ----------
    system_of : function    the system with a reduced body in it; other flexible bodies stay as they are, so
                            several are corrected one after the other
    body, frame, basis, derivatives, damping        the start, as for `reduce`
    target : SelfCorrection
    duration, output_step, step, method, tolerances, validity   of each run, as for `simulate`
    announce : function     called with every round as it is finished

    Returns
    -------
    SelfCorrected   .body, .solution, .estimated_error, .rounds

    Raises
    ------
    SelfCorrectionError     (an AccuracyError) the tolerance is not met; its `rounds` keep what was computed
    ModelError              the system does not hold the body; errors of `reduce`
    ConvergenceError        a run broke off before its first output time
    """
    full = FullBody(body, frame, damping)

    def run(basis: ReductionBasis) -> _Run:
        began = perf_counter()
        reduced = project(body, basis, damping=damping)
        system = system_of(reduced)
        if not any(placed.body is reduced for placed in system.bodies):
            raise ModelError(
                f"self-correction: the system does not hold the reduced body '{body.name}' it was given; "
                "`system_of` must place that very body"
            )
        parts: list[Solution] = []
        complete = True
        try:
            simulate(
                system,
                duration=duration,
                output_step=output_step,
                step=step,
                method=method,
                tolerances=tolerances,
                validity=validity,
                record=parts.append,
            )
        except ConvergenceError:
            # As a start without the derivatives it needs may: what it did until then shows what it lacks.
            if len(parts) < 2:
                raise
            complete = False
        return _Run(system, basis, reduced, concatenate(parts), complete, perf_counter() - began)

    rounds: list[Round] = []
    last_difference = np.inf
    current = run(reduction_basis(body, frame, basis, derivatives=derivatives))
    while True:
        began = perf_counter()
        missed = residual_corrections(
            current.system,
            full,
            current.basis,
            current.solution,
            _evenly_spread(len(current.solution.times), target.instants),
        )
        enriched = enrich(body, current.basis, missed.deformation, target.directions)
        seconds = current.seconds + perf_counter() - began
        finer = run(enriched.basis)
        difference = _largest_distance(current, finer)
        rounds.append(
            Round(
                body=current.body,
                solution=current.solution,
                estimated_error=_extrapolated(difference, last_difference),
                indicator=float(missed.rms.max()),
                singular_values=enriched.singular_values,
                seconds=seconds,
            )
        )
        if announce is not None:
            announce(rounds[-1])
        # The first round has no rate of convergence to go by: there the missing motion must agree.
        doubt = rounds[-1].indicator if len(rounds) == 1 else 0.0
        if max(rounds[-1].estimated_error, doubt) <= target.allowed(_largest_displacement(current)):
            return SelfCorrected(tuple(rounds), finer.body, finer.solution)
        _check_prospects(target, rounds, finer)
        current, last_difference = finer, difference


def _evenly_spread(n_times: int, n: int) -> np.ndarray:
    """Numbers of n output times up to the last, the start left out."""
    return np.unique(np.linspace(0, n_times - 1, n + 1).round().astype(int))[1:]


def _positions(run: _Run, rows: slice) -> np.ndarray:
    """Nodal positions in space, (t, N, 3)."""
    motion = run.solution.bodies[run.body.name]
    local = run.body.nodes + run.body.expand(motion.coordinates[rows])
    return motion.position[rows, None] + np.einsum("tij,tnj->tni", motion.rotation[rows], local)


_ROWS = 64
"""Output times whose nodal positions are held at once."""


def _largest_distance(run: _Run, finer: _Run) -> float:
    """Largest RMS distance of the nodes of two runs over time; infinite when one broke off."""
    if not (run.complete and finer.complete):
        return np.inf
    n = len(run.solution.times)
    rows = [slice(start, start + _ROWS) for start in range(0, n, _ROWS)]
    squares = [np.sum((_positions(run, part) - _positions(finer, part)) ** 2, axis=(1, 2)) for part in rows]
    return float(np.sqrt(np.concatenate(squares).max() / len(run.body.nodes)))


def _extrapolated(difference: float, last_difference: float) -> float:
    """Sum of the differences to come if each shrinks as the last one did."""
    if not np.isfinite(difference) or difference >= last_difference:
        return np.inf
    return difference / (1 - difference / last_difference)


def _largest_displacement(run: _Run) -> float:
    """Largest displacement of a node in its frame over the run."""
    coordinates = run.solution.bodies[run.body.name].coordinates
    parts = [
        np.linalg.norm(run.body.expand(coordinates[start : start + _ROWS]), axis=2).max()
        for start in range(0, len(coordinates), _ROWS)
    ]
    return float(max(parts))


def _check_prospects(target: SelfCorrection, rounds: list[Round], finer: _Run) -> None:
    """SelfCorrectionError when the next round would be one too many, or too large."""
    if finer.body.r > target.largest_size:
        reason = (
            f"the next basis would have {finer.body.r} coordinates, more than {target.largest_size} allowed"
        )
    elif len(rounds) > target.max_rounds:
        reason = f"{target.max_rounds} rounds are over"
    else:
        return
    history = ", ".join(f"{each.estimated_error:.2g} with {each.size} coordinates" for each in rounds)
    wanted = f"{target.absolute:g}" if target.relative is None else f"{target.relative:g} of the displacement"
    raise SelfCorrectionError(
        f"self-correction of body '{rounds[-1].body.name}' did not reach the error {wanted}: {reason}. "
        f"Estimated errors: {history}. Start with more modes (all those in the band of the loads), add more "
        "directions a round, tighten the tolerances of the time integration, or allow more; the rounds are "
        "kept in this error",
        tuple(rounds),
    )
